// mesh.toml.
#include "common.inc"
Settings(1)
Eye(<0, 45, 85>, <0, 6, 0>, y, 40)
background { rgb <0.45, 0.6, 0.9> }

light_source { <-60, 90, 60>, rgb 0.7 }
light_source { <80, 60, 20>, rgb 0.3 }

plane {
  y, -14
  pigment { rgb <0.6, 0.55, 0.5> }
  finish { Coefficients(0.15, 0.8, 0, 32) }
}

mesh2 {
  #include "mesh-mesh.inc"
  pigment { rgb <0.7, 0.2, 0.1> }
  finish { Coefficients(0.15, 0.8, 0.4, 60) }
}

sphere {
  <0, 8, 0>, 11
  pigment { rgb 1 }
  finish { Coefficients(0.02, 0.05, 0.6, 200) reflection 0.85 }
}
