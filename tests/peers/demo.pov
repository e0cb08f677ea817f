// scenes/demo.toml. 100 times as large, because POV-Ray skips shadows nearer than 0.001.
#include "common.inc"
#declare S = 100;
Settings(Code(230, 236, 255))
Eye(<0.5, 2.75, 8.4>*S, <0.05, 0.78, 0>*S, y, 25.5)
Sky(Code(42, 156, 255), Code(255, 250, 240))

light_source { <-4.5, 6.5, 5.0>*S, rgb Code(255, 241, 220)*0.95 }
light_source { <6.0, 4.0, 4.5>*S, rgb Code(207, 224, 255)*0.40 }

// The checks are 1/16 of the unit square around the cap.
#declare Check = 2*4.6/16;
cylinder {
  <0, -0.1, 0>, <0, 0.1, 0>, 4.6
  pigment { checker rgb Code(95, 127, 149), rgb Code(235, 229, 216) translate -0.5*y scale Check }
  finish { Coefficients(0.22, 0.62, 0, 32) reflection 0.10 }
  translate <0, -0.1, -0.4>
  scale S
}

// On each face: the matrix takes (u, v) to the place of the picture on it.
#declare Face = pigment { image_map { png "fence.png" gamma srgb interpolate 2 } }
box {
  -0.5, 0.5
  pigment {
    cubic
    pigment { Face matrix <0, 0, -1,  0, 1, 0,  1, 0, 0,  0, -0.5, 0.5> },
    pigment { Face matrix <1, 0, 0,  0, 0, -1,  0, 1, 0,  -0.5, 0, 0.5> },
    pigment { Face matrix <1, 0, 0,  0, 1, 0,  0, 0, 1,  -0.5, -0.5, 0> },
    pigment { Face matrix <0, 0, 1,  0, 1, 0,  1, 0, 0,  0, -0.5, -0.5> },
    pigment { Face matrix <1, 0, 0,  0, 0, 1,  0, 1, 0,  -0.5, 0, -0.5> },
    pigment { Face matrix <-1, 0, 0,  0, 1, 0,  0, 0, 1,  0.5, -0.5, 0> }
  }
  finish { Coefficients(0.25, 1.0, 0.08, 12) }
  scale <1.35, 2.1, 1.0>
  rotate -24*y
  translate <-1.8, 1.05, -0.6>
  scale S
}

// stone.png here is the picture three times side by side; 1.25 of it stand above each other.
#declare H = 2.3;
cone {
  -H/2*y, 0.92, H/2*y, 0
  pigment {
    image_map { png "stone3.png" gamma srgb map_type 2 interpolate 2 }
    matrix <0, 0, -1,  0, H/1.25, 0,  -1, 0, 0,  0, -H/2, 0>
  }
  finish { Coefficients(0.25, 1.0, 0.05, 8) }
  translate <1.95, 1.15, -0.75>
  scale S
}

sphere {
  <0.42, 0.72, -0.15>, 0.72
  pigment { rgb Code(223, 230, 238) }
  finish { Coefficients(0.03, 0.06, 0.8, 250) reflection 0.86 }
  scale S
}

cylinder {
  -0.625*y, 0.625*y, 0.40
  pigment { rgb Code(111, 16, 216) transmit 0.62 }
  finish { Coefficients(0.20/0.38, 0.38/0.38, 0.7, 120) reflection 0.12 }
  interior { ior 1.25 }
  translate <-0.72, 0.626, 1.2>
  scale S
}
