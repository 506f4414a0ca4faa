//! All objects of a scene, and the hierarchy that finds them.

use super::beam::Beam;
use super::build::{Item, Plan};
use super::contact::{Drop, Touch};
use super::cuboid::{Bounds, BoxQuery};
use super::instance::{Instance, is_well_conditioned};
use super::mesh::MeshTree;
use super::nearest::Nearest;
use super::solid::Solid;
use super::tree::{Stack, Tree};
use super::triangle::{ROUNDING, ShearedRay};
use super::{SphereContact, SurfaceHit, SurfaceId, SurfaceShape, keep_higher};
use fearless_simd::Simd;
use rayon::prelude::*;
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DAffine3, DMat3, DVec3, Ray};
use std::collections::HashMap;
use std::sync::Arc;

/// The objects, each in its place.
#[derive(Debug)]
pub(super) struct Places {
    /// In the order given.
    places: Vec<Place>,
    /// What instances are of; shared with the same objects elsewhere.
    meshes: Vec<Arc<MeshTree>>,
    /// Objects without a box that is to be trusted: tried one by one.
    unbounded: Vec<u32>,
    /// Over the others, relative to `center`.
    tree: Tree,
    /// The object of each leaf.
    leaves: Vec<u32>,
    center: DVec3,
    bounds: Aabb,
}

#[derive(Debug)]
enum Place {
    Solid(Solid),
    Mesh(Instance),
}

/// Meshes that are needed, each once, in the order of their first use.
#[derive(Default)]
struct Needed {
    meshes: Vec<Arc<TriangleMesh>>,
    index: HashMap<*const TriangleMesh, usize>,
}

impl Needed {
    /// Index of the mesh.
    fn find(&mut self, mesh: &Arc<TriangleMesh>) -> usize {
        *self.index.entry(Arc::as_ptr(mesh)).or_insert_with(|| {
            self.meshes.push(Arc::clone(mesh));
            self.meshes.len() - 1
        })
    }
}

/// A mesh and its place. What cannot be undone is done to a copy of the mesh.
fn mesh_place(
    mesh: &Arc<TriangleMesh>,
    transform: &DAffine3,
    needed: &mut Needed,
) -> (usize, DAffine3) {
    if is_well_conditioned(&transform.matrix3) {
        return (needed.find(mesh), *transform);
    }
    (needed.find(&Arc::new(mesh.transformed(transform))), DAffine3::IDENTITY)
}

impl Places {
    pub(super) fn new(objects: &[(SurfaceShape, DAffine3)]) -> Self {
        assert!(objects.len() <= Item::CAPACITY, "more than 2^30 objects");
        let mut needed = Needed::default();
        let wanted: Vec<_> = objects
            .iter()
            .map(|(shape, transform)| match shape {
                SurfaceShape::Mesh(mesh) => Some(mesh_place(mesh, transform, &mut needed)),
                SurfaceShape::Sphere | SurfaceShape::Box | SurfaceShape::Plane => None,
            })
            .collect();
        let meshes: Vec<Arc<MeshTree>> =
            needed.meshes.into_par_iter().map(|mesh| Arc::new(MeshTree::new(mesh))).collect();
        let place = |((shape, transform), wanted): (&(_, DAffine3), &Option<_>), object: u32| match (
            shape, wanted,
        ) {
            (SurfaceShape::Mesh(_), Some((mesh, transform))) => {
                Place::Mesh(Instance::new(object, *mesh, &meshes[*mesh], transform))
            }
            (SurfaceShape::Box, _) => Place::Solid(Solid::cuboid(object, transform)),
            (SurfaceShape::Plane, _) => Place::Solid(Solid::plane(object, transform)),
            (SurfaceShape::Sphere | SurfaceShape::Mesh(_), _) => {
                Place::Solid(Solid::sphere(object, transform))
            }
        };
        let places: Vec<Place> =
            objects.iter().zip(&wanted).zip(0u32..).map(|(of, object)| place(of, object)).collect();
        Self::over(places, meshes)
    }

    /// See [`super::Surfaces::turned`].
    pub(super) fn turned(&self, turn: &DMat3) -> Self {
        let turned = |place: &Place| match place {
            Place::Solid(solid) => Place::Solid(solid.turned(turn)),
            Place::Mesh(instance) => {
                Place::Mesh(instance.turned(&self.meshes[instance.mesh], turn))
            }
        };
        Self::over(self.places.iter().map(turned).collect(), self.meshes.clone())
    }

    fn over(places: Vec<Place>, meshes: Vec<Arc<MeshTree>>) -> Self {
        let boxes: Vec<Aabb> = places
            .par_iter()
            .with_min_len(16)
            .map(|place| match place {
                Place::Solid(solid) => solid.bounds(),
                Place::Mesh(instance) => instance.bounds(&meshes[instance.mesh]),
            })
            .collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(bounds));
        let center = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
        let (mut items, mut unbounded) = (Vec::new(), Vec::new());
        for ((place, bounds), object) in places.iter().zip(&boxes).zip(0u32..) {
            match place {
                Place::Solid(solid) if !solid.is_bounded() => unbounded.push(object),
                Place::Mesh(_) if bounds.is_empty() => {}
                _ => items.push(Item::new(Bounds::around(bounds, center), object)),
            }
        }
        let built = Plan { leaf_size: 1, same: None }.build(items);
        let leaves = built.leaves.iter().map(|leaf| built.items[leaf.start].number()).collect();
        Self { places, meshes, unbounded, tree: built.tree, leaves, center, bounds }
    }

    fn all_unbounded(&self) -> impl Iterator<Item = &Place> {
        self.unbounded.iter().map(|&object| &self.places[object as usize])
    }

    #[inline(always)]
    fn at(&self, object: u32) -> &Place {
        &self.places[object as usize]
    }

    fn half(&self) -> DVec3 {
        (self.bounds.max - self.center).max(self.center - self.bounds.min)
    }

    /// Bound of what roundings move, where coordinates go up to `size`.
    fn slack(&self, size: f64) -> f64 {
        (self.bounds.min.abs().max(self.bounds.max.abs()).max_element() + size) * ROUNDING
    }

    /// See [`super::Surfaces::intersect`].
    #[inline(always)]
    pub(super) fn intersect<S: Simd>(
        &self,
        simd: S,
        ray: &Ray,
        t_max: f64,
        exclude: Option<SurfaceId>,
    ) -> Option<SurfaceHit> {
        let mut nearest = Nearest::new(t_max);
        let sheared = ShearedRay::new(ray);
        for place in self.all_unbounded() {
            self.intersect_place(simd, place, (ray, &sheared), exclude, &mut nearest);
        }
        if let (true, Some(&object)) = (self.tree.nodes.is_empty(), self.leaves.first()) {
            self.intersect_place(simd, self.at(object), (ray, &sheared), exclude, &mut nearest);
            return nearest.hit(ray);
        }
        let spread = DVec3::splat(self.slack(ray.origin.abs().max_element()));
        let origin = ray.origin - self.center;
        let limit = nearest.limit();
        if let Some(beam) = Beam::new(self.half(), origin, ray.direction, spread, limit) {
            let mut stack = Stack::new();
            let mut walk = self.tree.walk(&self.leaves, &mut stack);
            while let Some(&object) = walk.next_along(simd, &beam, beam.limit(nearest.limit())) {
                let place = self.at(object);
                self.intersect_place(simd, place, (ray, &sheared), exclude, &mut nearest);
            }
        }
        nearest.hit(ray)
    }

    #[inline(always)]
    fn intersect_place<S: Simd>(
        &self,
        simd: S,
        place: &Place,
        ray: (&Ray, &ShearedRay),
        exclude: Option<SurfaceId>,
        nearest: &mut Nearest,
    ) {
        match place {
            Place::Mesh(instance) => {
                instance.intersect(simd, &self.meshes[instance.mesh], ray, exclude, nearest);
            }
            Place::Solid(solid) => {
                if let Some(hit) = solid.intersect(ray.0, exclude)
                    && nearest.is_met_before(hit.t, hit.id)
                {
                    nearest.keep_solid(hit);
                }
            }
        }
    }

    /// See [`super::Surfaces::is_met_again`].
    pub(super) fn is_met_again(&self, ray: &Ray, id: SurfaceId) -> bool {
        match self.places.get(id.object as usize) {
            Some(Place::Solid(solid)) => solid.intersect(ray, Some(id)).is_some(),
            Some(Place::Mesh(_)) | None => false,
        }
    }

    /// See [`super::Surfaces::may_cross`].
    #[inline(always)]
    pub(super) fn may_cross<S: Simd>(&self, simd: S, bounds: &Aabb) -> bool {
        let size = bounds.min.abs().max(bounds.max.abs()).max_element();
        let half = bounds.size() * 0.5 + self.slack(size);
        let query = BoxQuery::new(bounds.center() - self.center, half);
        let mut stack = Stack::new();
        let mut walk = self.tree.walk(&self.leaves, &mut stack);
        while let Some(&object) = walk.next_within(simd, &query) {
            if self.place_may_cross(simd, self.at(object), bounds) {
                return true;
            }
        }
        // Not by `any`: closures are not always inlined, and SIMD outside its level's function is
        // slow.
        for place in self.all_unbounded() {
            if self.place_may_cross(simd, place, bounds) {
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn place_may_cross<S: Simd>(&self, simd: S, place: &Place, bounds: &Aabb) -> bool {
        match place {
            Place::Solid(solid) => solid.may_cross(bounds),
            Place::Mesh(instance) => instance.may_cross(simd, &self.meshes[instance.mesh], bounds),
        }
    }

    /// See [`super::Surfaces::drop_sphere`]; the radius is above 0.
    #[inline(always)]
    pub(super) fn drop_sphere<S: Simd>(&self, simd: S, drop: &Drop) -> Option<SphereContact> {
        let mut first = None;
        for place in self.all_unbounded() {
            self.drop_on_place(simd, place, drop, &mut first);
        }
        let depth = |first: &Option<SphereContact>| drop.start_y - drop.floor(first.as_ref());
        let start = drop.start();
        let size = start.abs().max_element() + drop.radius;
        let spread = DVec3::splat(drop.radius + self.slack(size));
        let origin = start - self.center;
        let limit = depth(&first);
        if let Some(beam) = Beam::new(self.half(), origin, DVec3::NEG_Y, spread, limit) {
            let mut stack = Stack::new();
            let mut walk = self.tree.walk(&self.leaves, &mut stack);
            while let Some(&object) = walk.next_along(simd, &beam, beam.limit(depth(&first))) {
                self.drop_on_place(simd, self.at(object), drop, &mut first);
            }
        }
        first
    }

    #[inline(always)]
    fn drop_on_place<S: Simd>(
        &self,
        simd: S,
        place: &Place,
        drop: &Drop,
        first: &mut Option<SphereContact>,
    ) {
        match place {
            Place::Solid(solid) => solid.drop_sphere(drop, |y, touch, id| {
                keep_higher(first, SphereContact::new(y, touch, id));
            }),
            Place::Mesh(instance) => {
                instance.drop_sphere(simd, &self.meshes[instance.mesh], drop, first);
            }
        }
    }

    /// Calls `found` with all pieces that may be nearer to `center` than `reach`.
    #[inline(always)]
    pub(super) fn near<S: Simd>(
        &self,
        simd: S,
        center: DVec3,
        reach: f64,
        found: &mut impl FnMut(f64, Touch, SurfaceId),
    ) {
        for place in self.all_unbounded() {
            self.near_place(simd, place, (center, reach), found);
        }
        let half = DVec3::splat(reach + self.slack(center.abs().max_element()));
        let query = BoxQuery::new(center - self.center, half);
        let mut stack = Stack::new();
        let mut walk = self.tree.walk(&self.leaves, &mut stack);
        while let Some(&object) = walk.next_within(simd, &query) {
            self.near_place(simd, self.at(object), (center, reach), found);
        }
    }

    #[inline(always)]
    fn near_place<S: Simd>(
        &self,
        simd: S,
        place: &Place,
        (center, reach): (DVec3, f64),
        found: &mut impl FnMut(f64, Touch, SurfaceId),
    ) {
        match place {
            Place::Solid(solid) => solid.near(center, found),
            Place::Mesh(instance) => {
                instance.near(simd, &self.meshes[instance.mesh], (center, reach), found);
            }
        }
    }

    /// Box around all finite objects.
    pub(super) fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Whether no object has a surface.
    pub(super) fn is_empty(&self) -> bool {
        self.unbounded.is_empty() && self.leaves.is_empty()
    }

    /// Whether one of the objects is a plane.
    pub(super) fn has_infinite(&self) -> bool {
        self.all_unbounded().any(|place| match place {
            Place::Solid(solid) => solid.is_infinite(),
            Place::Mesh(_) => false,
        })
    }

    /// Memory beyond the value itself, bytes.
    pub(super) fn heap_bytes(&self) -> usize {
        let solids = self.places.iter().map(|place| match place {
            Place::Solid(solid) => solid.heap_bytes(),
            Place::Mesh(_) => 0,
        });
        self.places.capacity() * size_of::<Place>()
            + solids.sum::<usize>()
            + self.meshes.capacity() * size_of::<Arc<MeshTree>>()
            + self
                .meshes
                .iter()
                .map(|mesh| size_of::<MeshTree>() + mesh.memory_bytes())
                .sum::<usize>()
            + self.tree.memory_bytes()
            + (self.leaves.capacity() + self.unbounded.capacity()) * size_of::<u32>()
    }
}
