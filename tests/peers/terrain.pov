// terrain.toml.
#include "common.inc"
Settings(1)
Eye(<0, 30, 78>, <0, 3, 0>, y, 40)
background { rgb <0.45, 0.6, 0.9> }

light_source { <-60, 90, 60>, rgb 0.7 }
light_source { <80, 60, 20>, rgb 0.3 }

mesh2 {
  #include "terrain-mesh.inc"
  pigment { rgb <0.35, 0.5, 0.2> }
  finish { Coefficients(0.15, 0.85, 0.1, 20) }
}

#macro Ball(X, Y, Z, R) sphere { <X, Y, Z>, R texture { Glass } interior { ior 1.5 } } #end
#include "terrain-balls.inc"
