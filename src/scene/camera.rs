//! Primary rays.

use super::Scene;
use crate::bvh::{ExactRays, PACKET, RayPacket, Task};
use crate::description::{CameraDesc, Projection};
use crate::geometry::Ray;
use glam::{DVec2, DVec3};

/// Makes the primary ray of every point of the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    position: DVec3,
    /// Unit, into the scene.
    forward: DVec3,
    /// From the middle of the picture to its right edge (at distance 1 for a perspective view).
    right: DVec3,
    /// From the middle of the picture to its upper edge.
    up: DVec3,
    perspective: bool,
    /// Film size in pixels.
    size: (f64, f64),
}

impl Camera {
    /// `None` if the view direction is zero, parallel to `up` or not finite.
    pub fn new(desc: &CameraDesc, width: u32, height: u32) -> Option<Self> {
        let forward = (desc.look_at - desc.position).try_normalize()?;
        let right = forward.cross(desc.up.try_normalize()?).try_normalize()?;
        let up = right.cross(forward);
        let (half_height, perspective) = match desc.projection {
            Projection::Perspective { fov } => ((fov.to_radians() / 2.0).tan(), true),
            Projection::Orthographic { view_height } => (view_height / 2.0, false),
        };
        let half_width = half_height * f64::from(width) / f64::from(height);
        let (right, up) = (right * half_width, up * half_height);
        let finite = desc.position.is_finite() && right.is_finite() && up.is_finite() && forward.is_finite();
        let size = (f64::from(width), f64::from(height));
        finite.then_some(Self { position: desc.position, forward, right, up, perspective, size })
    }

    /// The ray through the point (x, y) of the film, in pixels from its upper left corner: the centre of pixel (i, j)
    /// is (i + 1/2, j + 1/2).
    #[inline(always)]
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let (width, height) = self.size;
        let across = self.right * ((2.0 * x - width) / width) + self.up * ((height - 2.0 * y) / height);
        if self.perspective {
            Ray::new(self.position, (self.forward + across).normalize())
        } else {
            Ray::new(self.position + across, self.forward)
        }
    }

    /// The point of the film that shows a point of the scene; `None` for what is not before the eye.
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        let off = point - self.position;
        let depth = off.dot(self.forward);
        let scale = if self.perspective { depth } else { 1.0 };
        let (x, y) = (off.dot(self.right) / self.right.length_squared(), off.dot(self.up) / self.up.length_squared());
        let (width, height) = self.size;
        let at = DVec2::new((x / scale + 1.0) * width, (1.0 - y / scale) * height) / 2.0;
        (depth > 0.0 && at.is_finite()).then_some(at)
    }

    /// Whether all primary rays start in one point.
    pub fn has_one_eye(&self) -> bool {
        self.perspective
    }

    /// The eye, or the middle of an orthographic picture.
    pub fn position(&self) -> DVec3 {
        self.position
    }
}

/// Makes the primary rays of points of the film, side by side.
struct Primary {
    camera: Camera,
    t_min: f64,
}

impl Task for Primary {
    type Input = [DVec2];
    type Output = ExactRays;

    #[inline(always)]
    fn run(self, points: &[DVec2], rays: &mut ExactRays) {
        for (i, point) in points.iter().take(PACKET).enumerate() {
            rays.put(i, &Ray { t_min: self.t_min, ..self.camera.ray(point.x, point.y) });
        }
    }
}

impl Scene {
    /// The rays of [`Camera::ray`] through points of the film, [`PACKET`] at most, which start at `t_min`.
    pub fn primary_rays(&self, t_min: f64, points: &[DVec2], rays: &mut RayPacket) {
        rays.set_len(points.len());
        self.run(Primary { camera: self.camera, t_min }, points, &mut rays.rows);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Isa;
    use crate::description::SceneDesc;
    use crate::math::SplitMix64;
    use crate::scene::compile_for;

    #[test]
    fn the_middle_of_the_film_looks_at_the_target_and_right_is_right() {
        let desc = CameraDesc { position: DVec3::new(0.0, 0.0, 5.0), look_at: DVec3::ZERO, ..CameraDesc::default() };
        let camera = Camera::new(&desc, 7, 5).unwrap();
        assert!(camera.ray(3.5, 2.5).direction.distance(DVec3::NEG_Z) < 1e-15);
        assert!(camera.ray(6.5, 2.5).direction.x > 0.0);
        assert!(camera.ray(3.5, 0.5).direction.y > 0.0);
        // The upper edge is half the vertical field of view away.
        let top = camera.ray(3.5, 0.0).direction;
        assert!((top.angle_between(DVec3::NEG_Z) - 20f64.to_radians()).abs() < 1e-12);
    }

    #[test]
    fn what_a_ray_meets_is_seen_where_the_ray_was_sent() {
        for projection in [Projection::Perspective { fov: 50.0 }, Projection::Orthographic { view_height: 3.0 }] {
            let desc = CameraDesc { position: DVec3::new(3.0, 2.0, 5.0), projection, ..CameraDesc::default() };
            let camera = Camera::new(&desc, 64, 48).unwrap();
            for (x, y) in [(0.5, 0.5), (32.0, 24.0), (63.9, 1.0), (-7.0, 60.0)] {
                let ray = camera.ray(x, y);
                let at = camera.project(ray.origin + ray.direction * 7.0).unwrap();
                assert!(at.distance(DVec2::new(x, y)) < 1e-9, "{at}");
                assert_eq!(camera.project(ray.origin - ray.direction * 7.0), None);
            }
        }
    }

    #[test]
    fn rays_side_by_side_have_the_bits_of_single_ones() {
        let mut random = SplitMix64(17);
        for isa in Isa::ALL.into_iter().filter(|isa| isa.is_available()) {
            for projection in [Projection::Perspective { fov: 70.0 }, Projection::Orthographic { view_height: 0.3 }] {
                let camera = CameraDesc { position: DVec3::new(3.0, 2.0, 5.0), projection, ..CameraDesc::default() };
                let scene = compile_for(&SceneDesc { camera, ..SceneDesc::default() }, None, isa).unwrap();
                for count in [0, 1, 7, 8, 100, PACKET] {
                    let mut place = || random.range(-1.0, 2000.0);
                    let points: Vec<_> = (0..count).map(|_| DVec2::new(place(), place())).collect();
                    let mut rays = RayPacket::default();
                    scene.primary_rays(1e-4, &points, &mut rays);
                    assert_eq!(rays.len(), count);
                    for (i, point) in points.iter().enumerate() {
                        let single = Ray { t_min: 1e-4, ..scene.camera.ray(point.x, point.y) };
                        assert_eq!(rays.ray(i), single);
                    }
                }
            }
        }
    }

    #[test]
    fn views_without_a_direction_are_refused() {
        let at = |position, up| Camera::new(&CameraDesc { position, up, ..CameraDesc::default() }, 4, 4);
        assert!(at(DVec3::ZERO, DVec3::Y).is_none());
        assert!(at(DVec3::Y, DVec3::Y).is_none());
        assert!(at(DVec3::X * f64::INFINITY, DVec3::Y).is_none());
    }
}
