// glass.toml.
#include "common.inc"
Settings(1)
Eye(<10, 45, 120>, <0, 0, 20>, y, 40)
Sky(<0.2, 0.4, 0.9>, <1, 1, 1>)

light_source { <-100, 150, 100>, rgb 0.7 }
light_source { <120, 100, 40>, rgb 0.3 }

// glimt's v is -z, so the first colour is at x > 0, z < 0.
plane {
  y, 0
  pigment { checker rgb <0.1, 0.15, 0.3>, rgb <0.8, 0.8, 0.75> translate -0.5*y scale 5 }
  finish { Coefficients(0.15, 0.8, 0, 32) }
}

#macro Ball(X, Y, Z, R) sphere { <X, Y, Z>, R texture { Glass } interior { ior 1.5 } } #end
#macro Cuboid(Size, Angle, Place)
  box { -Size/2, Size/2 texture { Glass } interior { ior 1.5 } rotate Angle*y translate Place }
#end
#include "glass-balls.inc"
#include "glass-boxes.inc"
