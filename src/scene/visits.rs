//! How much of the hierarchies a ray looks at.

use super::leaf::Closest;
use super::{Scene, Shape};
use crate::bvh::{Counted, Lanes, LeafVisitor, TreeKernels};
use crate::geometry::{Hit, Ray};

/// Follows a ray as [`Scene::intersect`] does, or with `ANY` as [`Scene::occluded`], and counts in the trees of meshes.
struct Follow<'a, K, const ANY: bool> {
    scene: &'a Scene,
    closest: Closest<'a, K>,
    /// In trees of meshes.
    visits: u64,
}

impl<'a, K: TreeKernels, const ANY: bool> LeafVisitor for Follow<'a, K, ANY> {
    type Source = (&'a Scene, Option<Hit>);
    type Found = u64;
    const ANY_HIT: bool = ANY;

    #[inline(always)]
    fn new(source: Self::Source, ray: &Ray) -> Self {
        Self { scene: source.0, closest: Closest::new(source, ray), visits: 0 }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, _lanes: L, block: u32, t_max: &mut f64) -> bool {
        let index = self.scene.geometry.leaves[block as usize].object;
        let object = &self.scene.objects()[index as usize];
        let ray = Ray { t_max: *t_max, ..self.closest.ray };
        if let Shape::Mesh(mesh) = &object.shape {
            self.visits += mesh.visits::<K>(&ray.transformed(&object.map.inverse), ANY);
        }
        if ANY {
            return object.intersect::<K>(&ray, index).is_some();
        }
        *t_max = self.closest.test(index, *t_max);
        false
    }

    #[inline(always)]
    fn found(self, _ended: bool) -> u64 {
        self.visits
    }
}

impl Scene {
    /// Nodes opened and leaves tested, in the tree over the objects and in those of meshes, to find what a ray meets
    /// when it is traced alone; with `any`, to find whether it meets anything. Planes are in no tree.
    pub fn visits<K: TreeKernels>(&self, ray: &Ray, any: bool) -> u64 {
        if any { self.count::<K, true>(ray) } else { self.count::<K, false>(ray) }
    }

    fn count<K: TreeKernels, const ANY: bool>(&self, ray: &Ray) -> u64 {
        let geometry = &*self.geometry;
        let mut planes = Closest::<K>::new((self, None), ray);
        let t_max = geometry.unbounded.iter().fold(ray.t_max, |t_max, &index| planes.test(index, t_max));
        if ANY && planes.best.is_some() {
            return 0;
        }
        let source = (self, planes.best);
        let ray = Ray { t_max, ..*ray };
        let (visits, in_meshes) = geometry.tree.traverse::<K::Boxes, Counted<Follow<K, ANY>>>(&ray, source);
        visits + in_meshes
    }
}
