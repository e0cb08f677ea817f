//! **glimt** is a progressive renderer for Whitted ray tracing that runs in a terminal.
//!
//! # The one path of data
//!
//! ```text
//! scene.toml --parse--> SceneDesc --compile--> Arc<Scene> --start--> RenderHandle --RenderEvent--> Film --> preview, PNG
//!                        ^                     (the previous Scene lends every part that did not change)
//!         key -> Command |
//!                       App::update (no IO) -> Effect
//! ```
//!
//! Headless rendering is this path with a loop over the events, a study is that in a loop over settings, the terminal
//! interface is this path with keys. None knows the others.
//!
//! # Layers
//!
//! Each module may use those before it, never after; siblings (between commas) not at all. `tests/layers.rs` holds
//! the table and fails when a file breaks it.
//!
//! ```text
//! math, workers < geometry, description < bvh, assets < scene < shading < render < output, advice < headless, study, tui < cli < main
//! ```
//!
//! # Glossary
//!
//! | term | meaning |
//! |---|---|
//! | [`SceneDesc`](description::SceneDesc) | what the user wrote: names, numbers, paths |
//! | [`Scene`](scene::Scene) | what rays meet: indices, boxes, trees |
//! | [`Ray`](geometry::Ray) | origin, direction and the interval t_min < t <= t_max; f64, world or object space |
//! | [`Hit`](geometry::Hit) | what traversal returns: distance and which primitive; small |
//! | [`SurfaceInteraction`](geometry::SurfaceInteraction) | point, error bound, normals, uv of the winning hit; built once |
//! | [`Aabb`](geometry::Aabb), [`Bvh`](bvh::Bvh) | axis-aligned box; hierarchy of them, its nodes and leaves |
//! | [`Tile`](render::Tile), [`Pass`](render::Pass) | a rectangle of pixels with its sums; which samples are traced next |
//! | [`Film`](render::Film) | the picture as far as it is known, in linear light |
//! | [`Rgb`](math::Rgb) | linear Rec. 709 colour |
//! | radiance | what a ray sees: the recursive function of [`shading`] |
//! | error bound, watertight | a proven limit of rounding; a surface that no ray slips through |
//!
//! Lengths are scene units; angles are degrees in files and on screen, radians in memory; time is `Duration`.

pub mod advice;
pub mod assets;
pub mod bvh;
pub mod cli;
pub mod description;
pub mod geometry;
pub mod headless;
pub mod math;
pub mod output;
pub mod render;
pub mod scene;
pub mod shading;
pub mod study;
pub mod tui;
pub mod workers;
