// scenes/sphereflake.toml. 100 times as large, because POV-Ray skips shadows nearer than 0.001.
#include "common.inc"
#declare S = 100;
Settings(0)
Eye(<2.1, 1.3, 1.7>*S, <0, 0, 0>, z, 45)
background { rgb <0.078, 0.361, 0.753> }

light_source { <4, 3, 2>*S, rgb 0.57735 }
light_source { <1, -4, 4>*S, rgb 0.57735 }
light_source { <-3, 1, 5>*S, rgb 0.57735 }

mesh {
  triangle { <-12, -12, -0.5>, <12, -12, -0.5>, <12, 12, -0.5> }
  triangle { <-12, -12, -0.5>, <12, 12, -0.5>, <-12, 12, -0.5> }
  pigment { rgb <1.0, 0.75, 0.33> }
  finish { Coefficients(0.2, 0.8, 0, 32) }
  scale S
}

#declare Mirror = texture {
  pigment { rgb <1.0, 0.9, 0.7> }
  finish { Coefficients(0, 0.5, 0.5, 40) reflection 0.5 }
}
#macro Ball(X, Y, Z, R) sphere { <X, Y, Z>*S, R*S texture { Mirror } } #end
#include "sphereflake.inc"
