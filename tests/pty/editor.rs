//! Everything that the editor can do, done by keys and mouse in the real program, with what it has saved.

use super::session::{Kind, Session, USUAL};
use glam::DVec3;
use glimt::description::{SceneDesc, Source, parse};
use glimt::tui::camera;
use portable_pty::CommandBuilder;
use std::fs;
use std::path::Path;

const DESK: Kind = Kind { columns: 120, rows: 44, ..USUAL };

/// What the sessions begin with.
const SCENE: &str = r#"# a table for tests
[film]
width = 160                # small
height = 90

[camera]
position = [0, 1, 8]
look_at = [0, 0, 0]
fov = 40

[render]
samples = 1

[[light]]
name = "lamp"
position = [4, 6, 3]       # above

[[material]]
name = "paint"             # one of
color = "tomato"

[[object]]
name = "left"
shape = "sphere"
radius = 0.75              # round
translate = [-1, 0, 0]
material = "paint"

[[object]]
name = "right"
shape = "sphere"
radius = 0.75
translate = [1, 0, 0]
material = "paint"

[[object]]
name = "floor"
shape = "plane"
translate = [0, -1, 0]     # below
"#;

const MODEL: &str = "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// The program with the scene in a directory in which there are a model, a picture, and files that cannot be opened.
fn start(test: &str) -> Session {
    let session = Session::start_with(&format!("editor-{test}"), DESK, SCENE, |program| {
        let mut command = CommandBuilder::new(program);
        command.arg("ball.toml");
        command
    });
    session.wait_for_status("saved ball.png");
    session
}

fn furnish(session: &Session) {
    fs::write(session.directory.join("box.obj"), MODEL).unwrap();
    fs::write(session.directory.join("notes.txt"), "nothing\n").unwrap();
    let picture = image::RgbImage::from_fn(8, 8, |x, y| image::Rgb([200, 30 * x as u8, 30 * y as u8]));
    picture.save(session.directory.join("cloth.png")).unwrap();
}

/// Saves to the scene's own file and returns it.
fn save(session: &Session) -> String {
    session.press("w");
    session.wait_for_status("saved ball.toml");
    session.wait("no mark", |screen| !screen.contents().contains("● not saved"));
    session.read("ball.toml")
}

/// Leaves; there is nothing to ask.
fn leave(mut session: Session) {
    session.press("q");
    assert_eq!(session.end(), 0);
    session.assert_restored();
}

#[test]
fn every_kind_of_thing_is_added_and_saved_under_another_name() {
    let session = start("add");
    furnish(&session);
    for (letter, name) in [
        ("s", "sphere"),
        ("b", "cuboid"),
        ("c", "cylinder"),
        ("k", "cone"),
        ("p", "plane"),
        ("q", "quad"),
        ("l", "lamp 2"),
        ("d", "sun"),
        ("m", "material"),
    ] {
        session.press("a");
        session.wait_for_text("directional light");
        session.press(letter);
        session.wait_for_status(&format!("added {name}"));
        session.wait_for_text("● not saved");
    }
    // A model, from a list of what can be opened.
    session.press("a f");
    session.wait("list of models", |screen| screen.contents().contains("box.obj"));
    assert!(!session.contents().contains("notes.txt") && !session.contents().contains("cloth.png"));
    session.send("box");
    session.wait("only what fits", |screen| !screen.contents().contains("../"));
    session.press("Enter");
    session.wait_for_status("added box");
    session.press("W");
    session.wait_for_text("Save the scene as");
    session.send(&"\x7f".repeat(300));
    session.send("all.txt\r");
    session.wait_for_text("the name of a scene ends in .toml");
    session.send(&"\x7f".repeat(3));
    session.send("toml\r");
    session.wait_for_status("saved all.toml");
    assert_eq!(session.read("ball.toml"), SCENE);
    assert_eq!(session.read("all.toml"), ADDED);
    leave(session);
}

const ADDED: &str = r##"# a table for tests
[film]
width = 160                # small
height = 90

[camera]
position = [0, 1, 8]
look_at = [0, 0, 0]
fov = 40

[render]
samples = 1

[[light]]
name = "lamp"
position = [4, 6, 3]       # above

[[light]]
name = "lamp 2"
kind = "point"
position = [3.4, 6, 4.1]
intensity = 0.5

[[light]]
name = "sun"
kind = "directional"
direction = [-0.43, -0.75, -0.51]
intensity = 0.5

[[material]]
name = "paint"             # one of
color = "tomato"

[[material]]
name = "sphere"
color = "#3d7ea6"

[[material]]
name = "cuboid"
color = "#e0a030"

[[material]]
name = "cylinder"
color = "#588157"

[[material]]
name = "cone"
color = "#8d6a9f"

[[material]]
name = "plane"
color = "#b0b0b0"

[[material]]
name = "quad"
color = "#c8553d"

[[material]]
name = "material"
color = "#3d7ea6"

[[object]]
name = "left"
shape = "sphere"
radius = 0.75              # round
translate = [-1, 0, 0]
material = "paint"

[[object]]
name = "right"
shape = "sphere"
radius = 0.75
translate = [1, 0, 0]
material = "paint"

[[object]]
name = "floor"
shape = "plane"
translate = [0, -1, 0]     # below

[[object]]
name = "sphere"
shape = "sphere"
radius = 0.75
material = "sphere"

[[object]]
name = "cuboid"
shape = "cuboid"
size = [1.5, 1.5, 1.5]
material = "cuboid"

[[object]]
name = "cylinder"
shape = "cylinder"
radius = 0.75
height = 1.5
material = "cylinder"

[[object]]
name = "cone"
shape = "cone"
radius = 0.75
height = 1.5
material = "cone"

[[object]]
name = "plane"
shape = "plane"
material = "plane"
translate = [0, -0.75, 0]

[[object]]
name = "quad"
shape = "quad"
size = [1.5, 1.5]
material = "quad"

[[object]]
name = "box"
shape = "mesh"
file = "box.obj"
scale = 0.75
"##;

/// The scene with the entries from this line on replaced: what the file is to be after a session.
fn with(changes: &[(&str, &str)]) -> String {
    let mut text = SCENE.to_owned();
    for (before, after) in changes {
        assert_eq!(text.matches(before).count(), 1, "{before}\n{text}");
        text = text.replace(before, after);
    }
    text
}

#[test]
fn the_tree_hides_renames_duplicates_deletes_orders_and_finds() {
    let session = start("tree");
    session.choose("left");
    session.press("v");
    session.wait_for_text("hidden sphere");
    session.press("v");
    session.wait("it again", |screen| !screen.contents().contains("hidden"));
    session.choose("plane");
    session.press("v");
    session.wait_for_text("hidden plane");
    session.choose("left");
    session.press("e");
    session.wait_for_text("Rename");
    session.send("\x7f\x7f\x7f\x7fbig ball\r");
    session.wait_for_text("big ball ");
    session.press("y");
    session.wait_for_text("big ball 2 ");
    session.press("> >");
    session.choose("right");
    session.press("x");
    session.wait_for_status("deleted right; u brings it back");
    session.press("u");
    session.wait_for_status("undone: delete right");
    session.press("U");
    session.wait_for_status("done again: delete right");
    session.choose("lamp");
    session.press("y");
    session.wait_for_text("lamp 2 ");
    session.press("Delete");
    session.wait_for_status("deleted lamp 2");
    session.choose("paint");
    session.press("e");
    session.wait_for_text("Rename");
    session.send(" red\r");
    session.wait_for_text("paint red");
    // A search by kind shows nothing else.
    session.send("/plane");
    session.wait("only the floor", |screen| {
        let text = screen.contents();
        text.contains("floor") && !text.contains("big ball") && !text.contains("lamp")
    });
    session.press("Escape");
    session.wait_for_text("big ball");
    assert_eq!(save(&session), TREE);
    leave(session);
}

const TREE: &str = r##"# a table for tests
[film]
width = 160                # small
height = 90

[camera]
position = [0, 1, 8]
look_at = [0, 0, 0]
fov = 40

[render]
samples = 1

[[light]]
name = "lamp"
position = [4, 6, 3]       # above

[[material]]
name = "paint red"             # one of
color = "tomato"

[[object]]
name = "big ball"
shape = "sphere"
radius = 0.75              # round
translate = [-1, 0, 0]
material = "paint red"

[[object]]
name = "floor"
shape = "plane"
translate = [0, -1, 0]     # below
visible = false

[[object]]
name = "big ball 2"
shape = "sphere"
radius = 0.75
translate = [-0.5, 0, 0]
material = "paint red"
"##;

#[test]
fn one_and_several_are_moved_turned_and_scaled_by_keys_numbers_and_expressions() {
    let session = start("transform");
    session.choose("left");
    session.press("g x 2 * ( 1 + 3 ) / 8");
    session.wait_for_status("move x: 2*(1+3)/8");
    session.press("Enter g y Up Up Shift-Up Enter");
    session.press("t z 4 5 Enter z x 1 . 5 Enter");
    session.choose("right");
    session.press("g v z - 1 Enter");
    // Taken back.
    session.press("g x 5");
    session.wait_for_status("move x: 5");
    session.press("Escape z Right Shift-Right Enter");
    session.choose("lamp");
    session.press("g y 1 Enter");
    // Both balls about the point between them.
    session.choose("left");
    session.press("Shift-Down");
    session.wait_for_text("2 selected");
    session.press("t y 9 0 Enter");
    session.press("z * 2 Enter");
    session.press("u U");
    session.wait_for_status("done again: scale 2 things");
    // What they have in common is shown, what differs as mixed; an edit is for all.
    session.press("Enter");
    session.enter("translate y", "+0.25", "mixed");
    session.enter("radius", "*2", "1.5");
    // Those that are marked one by one.
    session.press("Tab Tab");
    session.choose("floor");
    session.press("Space");
    session.choose("lamp");
    assert_eq!(save(&session), TRANSFORMED);
    leave(session);
}

const TRANSFORMED: &str = r##"# a table for tests
[film]
width = 160                # small
height = 90

[camera]
position = [0, 1, 8]
look_at = [0, 0, 0]
fov = 40

[render]
samples = 1

[[light]]
name = "lamp"
position = [4, 7, 3]       # above

[[material]]
name = "paint"             # one of
color = "tomato"

[[object]]
name = "left"
shape = "sphere"
radius = 1.5              # round
translate = [-0.810936033726, 2.10057458733, 1.93694772503]
material = "paint"
rotate = [90, 45, 90]
scale = [2.5495097568, 2.5495097568, 2]

[[object]]
name = "right"
shape = "sphere"
radius = 1.5
translate = [1.17361966107, -0.051355951657, -0.0630522068574]
material = "paint"
rotate = [0, 90, 0]
scale = 3.15

[[object]]
name = "floor"
shape = "plane"
translate = [0, -1, 0]     # below
"##;

#[test]
fn every_property_is_a_row_that_is_turned_typed_and_reset() {
    let session = start("properties");
    session.choose("paint");
    session.press("Enter");
    session.enter("ambient", "0.3", "0.3");
    session.to_property("diffuse");
    session.press("Right Right Shift-Right");
    session.enter("specular", "*2", "0.");
    session.enter("shininess", "2^6", "64");
    session.enter("reflect", "1/4", "0.25");
    session.enter("transmit", "0.5", "0.5");
    session.enter("ior", "1.5", "1.5");
    session.to_property("fresnel");
    session.press("Enter");
    session.wait_for_property("fresnel", "on");
    session.enter("priority", "2", "2");
    // Out of its range: told, and typed anew.
    session.to_property("reflect");
    session.press("Enter");
    session.send("\x7f\x7f\x7f\x7f\x7f\x7f7\r");
    session.wait_for_status("reflect must be");
    session.press("Escape");
    session.to_property("transmit");
    session.press("Backspace");
    session.wait_for_property("transmit", "0");
    session.to_property("texture");
    session.press("Right");
    session.wait_for_property("texture", "‹ checker ›");
    session.to_property("checker second");
    session.press("Enter");
    session.wait_for_text("saturation");
    session.send("#000080\r");
    session.enter("checker size", "0.5", "0.5");
    session.enter("texture scale u", "3", "3");
    session.press("Tab Tab");
    session.choose("world");
    session.press("Enter");
    session.to_property("background");
    session.press("Right");
    session.wait_for_property("background", "‹ gradient ›");
    session.to_property("background top");
    session.press("Enter");
    session.wait_for_text("saturation");
    session.send("#112233\r");
    session.enter("ior", "1.33", "1.33");
    session.press("Tab Tab");
    session.choose("render");
    session.press("Enter");
    session.to_property("shading");
    session.press("Left");
    session.wait_for_property("shading", "‹ phong ›");
    session.enter("max_depth", "3", "3");
    session.enter("samples", "2", "2");
    session.to_property("until error");
    session.press("Enter");
    session.enter("error", "4", "4");
    session.to_property("filter");
    session.press("Right");
    session.wait_for_property("filter", "‹ tent ›");
    session.to_property("shadows");
    session.press("Right");
    session.to_property("numerics");
    session.press("Right");
    session.press("Tab Tab");
    session.choose("film");
    session.press("Enter");
    session.enter("width", "-=40", "120");
    session.press("Tab Tab");
    session.choose("lamp");
    session.press("Enter");
    session.to_property("falloff");
    session.press("Right");
    session.enter("intensity", "0.75", "0.75");
    session.press("Tab Tab");
    session.choose("left");
    session.press("Enter");
    session.enter("rotate y", "pi/2 rad", "90");
    session.enter("scale x", "2", "2");
    session.press("Tab Tab");
    session.choose("camera");
    session.press("Enter");
    session.enter("fov", "+5", "45");
    session.enter("position x", "0.5", "0.5");
    assert_eq!(save(&session), PROPERTIES);
    leave(session);
}

const PROPERTIES: &str = r##"# a table for tests
[film]
width = 120                # small
height = 90

[camera]
position = [0.5, 1, 8]
look_at = [0, 0, 0]
fov = 45

[render]
samples = 2
shading = "phong"
max_depth = 3
filter = "tent"
shadows = "filtered"
numerics = "reference"
error = 4

[[light]]
name = "lamp"
position = [4, 6, 3]       # above
falloff = "inverse-square"
intensity = 0.75

[[material]]
name = "paint"             # one of
color = "tomato"
texture = { checker = ["#ff6347", "#000080"], size = 0.5, scale = [3, 1] }
ambient = 0.3
diffuse = 0.86
specular = 0.4
shininess = 64
reflect = 0.25
fresnel = true
priority = 2

[[object]]
name = "left"
shape = "sphere"
radius = 0.75              # round
translate = [-1, 0, 0]
material = "paint"
rotate = [0, 90, 0]
scale = [2, 1, 1]

[[object]]
name = "right"
shape = "sphere"
radius = 0.75
translate = [1, 0, 0]
material = "paint"

[[object]]
name = "floor"
shape = "plane"
translate = [0, -1, 0]     # below

[world]
background = { top = "#112233", bottom = "#000000" }
ior = 1.33
"##;

#[test]
fn colours_and_textures_are_chosen_in_dialogs_and_seen_at_once() {
    let session = start("dialogs");
    furnish(&session);
    session.choose("left");
    session.press("C");
    session.wait_for_text("saturation");
    // Red by one, then the code of another colour, which is taken back.
    session.press("Right");
    session.wait_for_text("#ff6347");
    session.press("Left Left");
    session.wait_for_text("#fd6347");
    session.press("Escape");
    session.press("C");
    session.wait_for_text("#ff6347");
    session.send("steelblue");
    // The ball has it while the dialog is open.
    session.wait("a blue ball", |screen| has_color(screen, |r, g, b| b > 100 && b - r.min(b) > 40 && b > g));
    session.press("Enter");
    // A light by the sliders; the colour before is among the recent ones.
    session.choose("lamp");
    session.press("C");
    session.wait_for_text("recent");
    session.press("Down Down Shift-Left Shift-Left");
    session.wait_for_text("#ffffeb");
    session.press("Enter");
    session.choose("world");
    session.press("C");
    session.wait_for_text("background color");
    session.send("#203040\r");
    // A picture on an object that has no material yet.
    session.choose("floor");
    session.press("T");
    session.wait_for_text("cloth.png");
    assert!(!session.contents().contains("notes.txt") && !session.contents().contains("box.obj"));
    session.send("cloth");
    session.wait_for_text("8×8");
    session.wait("the picture small", |screen| has_color(screen, |r, g, b| (r, g, b) == (200, 0, 210)));
    session.press("Enter");
    session.wait_for_text("▸ wrap");
    session.press("Right Down Right Right Down Shift-Right Enter");
    session.wait("end of the dialog", |screen| !screen.contents().contains("▸ texture scale"));
    assert_eq!(save(&session), DIALOGS);
    leave(session);
}

const DIALOGS: &str = r##"# a table for tests
[film]
width = 160                # small
height = 90

[camera]
position = [0, 1, 8]
look_at = [0, 0, 0]
fov = 40

[render]
samples = 1

[[light]]
name = "lamp"
position = [4, 6, 3]       # above
color = "#ffffeb"

[[material]]
name = "paint"             # one of
color = "#4682b4"

[[material]]
name = "material"
color = "#3d7ea6"
texture = { file = "cloth.png", wrap = "clamp", scale = [1.1, 1.5] }

[[object]]
name = "left"
shape = "sphere"
radius = 0.75              # round
translate = [-1, 0, 0]
material = "paint"

[[object]]
name = "right"
shape = "sphere"
radius = 0.75
translate = [1, 0, 0]
material = "paint"

[[object]]
name = "floor"
shape = "plane"
translate = [0, -1, 0]     # below
material = "material"

[world]
background = "#203040"
"##;

fn has_color(screen: &vt100::Screen, wanted: impl Fn(u8, u8, u8) -> bool) -> bool {
    !cells(screen, wanted).is_empty()
}

/// Columns and rows of the cells of the picture, or of dialogs over it, one of whose pixels has such a colour.
fn cells(screen: &vt100::Screen, wanted: impl Fn(u8, u8, u8) -> bool) -> Vec<(u16, u16)> {
    let all = (0..DESK.rows).flat_map(|y| (0..DESK.columns - 38).map(move |x| (x, y)));
    let is_wanted = |color| matches!(color, vt100::Color::Rgb(r, g, b) if wanted(r, g, b));
    let has = |(x, y): &(u16, u16)| {
        screen.cell(*y, *x).is_some_and(|cell| [cell.fgcolor(), cell.bgcolor()].into_iter().any(is_wanted))
    };
    all.filter(has).collect()
}

/// What the file is to hold after a change of the description.
fn saved_with(change: impl FnOnce(&mut SceneDesc)) -> String {
    let file = Path::new("/nowhere/ball.toml");
    let before = parse(SCENE, file).unwrap();
    let mut after = before.clone();
    change(&mut after);
    glimt::description::save(Source { text: SCENE, desc: &before, file }, &after, file).unwrap()
}

#[test]
fn the_camera_orbits_pans_comes_nearer_frames_and_returns_to_views() {
    let session = start("camera");
    session.press("Left Up l k h j Right");
    session.press("Shift-Right K i i o f f F");
    session.wait_for_status("field of view");
    session.press("V");
    session.wait_for_text("Keep this view");
    session.press("1");
    session.wait_for_status("this is view 1 now");
    session.press("2");
    session.wait_for_status("there is no view 2 yet");
    // The ball at the right fills the view; then back.
    session.choose("right");
    session.press(". 1");
    session.wait_for_status("view 1");
    session.press("u");
    session.wait_for_status("undone: recall view");
    session.press("U");
    session.wait_for_status("done again: recall view");
    let expected = saved_with(|desc| {
        let eye = &mut desc.camera;
        for (right, above) in [(-1, 0), (0, 1), (1, 0), (0, 1), (-1, 0), (0, -1), (1, 0)] {
            camera::orbit(eye, f64::from(right) * 5.0, f64::from(above) * 5.0);
        }
        camera::pan(eye, 0.05, 0.0);
        camera::pan(eye, 0.0, 0.05);
        for factor in [0.9, 0.9, 0.9f64.powi(-1)] {
            camera::dolly(eye, factor);
        }
        for factor in [1.05f64.powi(-1), 1.05f64.powi(-1), 1.05] {
            camera::widen(eye, factor);
        }
    });
    assert_eq!(save(&session), expected);
    session.press("c");
    session.wait_for_status("the camera is that of the scene again");
    session.choose("right");
    session.press(".");
    let framed = saved_with(|desc| {
        // The half diagonal of the ball's box.
        camera::frame(&mut desc.camera, 160.0 / 90.0, DVec3::X, 0.75 * 3f64.sqrt());
    });
    let (framed, saved) = (parse(&framed, Path::new("/a")).unwrap(), parse(&save(&session), Path::new("/a")).unwrap());
    assert!(saved.camera.position.distance(framed.camera.position) < 1e-4, "{:?}", saved.camera);
    assert!(saved.camera.look_at.distance(framed.camera.look_at) < 1e-5);
    leave(session);
}

#[test]
fn pixels_are_picked_and_explained_by_keys_and_by_the_mouse() {
    let session = start("pick");
    session.press("Enter");
    session.wait_for_status("select");
    // From the middle to the left ball.
    session.press("Shift-Left");
    session.wait_for_status("left");
    session.press("Y");
    session.wait_for_text("Why this colour?");
    session.wait_for_text("left");
    session.wait_for_text("k_d");
    session.press("Escape");
    session.wait("end of the box", |screen| !screen.contents().contains("Why this colour?"));
    session.press("Enter Escape");
    session.wait("the ball in the properties", |screen| below_the_tree(screen).contains("left"));
    // The other one with the mouse, and both with a modifier.
    let red = |screen: &vt100::Screen| cells(screen, |r, g, b| r > 120 && g < r / 2 && b < r / 2);
    session.wait("both balls", |screen| {
        let right = red(screen).iter().filter(|(x, _)| *x > 41).count();
        right > 15 && red(screen).len() > right + 15
    });
    let balls = red(session.far().parser.screen());
    // One in the midst of each.
    let of = |side: fn(u16) -> bool| {
        let cells: Vec<_> = balls.iter().filter(|(x, _)| side(*x)).collect();
        *cells[cells.len() / 2]
    };
    let (left, right) = (of(|x| x < 41), of(|x| x > 41));
    session.click(right.0, right.1, false);
    session.wait("the other ball", |screen| below_the_tree(screen).contains("right"));
    session.click(left.0, left.1, true);
    session.wait_for_text("2 selected");
    session.press("Y");
    session.wait_for_text("Why this colour?");
    session.press("Escape");
    session.wait("end of the box", |screen| !screen.contents().contains("Why this colour?"));
    // A click beside everything is the world: the sky begins in the upper left corner of the picture.
    let sky = cells(session.far().parser.screen(), |_, _, _| true).into_iter().min_by_key(|(x, y)| (*y, *x)).unwrap();
    session.click(sky.0, sky.1 + 1, false);
    session.wait("the world", |screen| below_the_tree(screen).contains("background"));
    assert!(!session.contents().contains("● not saved"));
    leave(session);
}

/// The properties: what stands below the line under the tree.
fn below_the_tree(screen: &vt100::Screen) -> String {
    screen.contents().lines().skip_while(|row| !row.contains("├──")).collect::<Vec<_>>().join("\n")
}

#[test]
fn views_help_palette_and_adviser_are_there() {
    let session = start("look");
    session.press(")");
    session.wait_for_status("view: normals");
    session.press("( (");
    session.wait_for_status("view: non-finite");
    session.press(")");
    session.wait_for_status("view: final");
    session.press("?");
    session.wait_for_text("find a command");
    session.press("Escape");
    session.wait("end of the help", |screen| !screen.contents().contains("find a command"));
    // A command without a key, by a part of its name.
    session.press(":");
    session.wait_for_text("Commands");
    session.send("show depth\r");
    session.wait_for_status("view: depth");
    session.press(":");
    session.wait_for_text("Commands");
    session.send("show light\r");
    session.wait_for_status("view: final");
    // The adviser: the floor is no mirror, so nothing needs the depth. What is above that in the list hangs on the time that it
    // saves.
    let take_depth = || {
        session.press("A");
        session.wait_for_text("no mirror and no glass is seen");
        let text = session.contents();
        let above = text.lines().take_while(|row| !row.contains("no mirror")).filter(|row| row.contains("saves"));
        above.for_each(|_| session.press("Down"));
        session.press("Enter");
        session.wait_for_text("● not saved");
    };
    take_depth();
    session.press("Escape");
    session.wait("end of the adviser", |screen| !screen.contents().contains("saves"));
    session.press("u");
    session.wait_for_status("undone: advice");
    session.wait("no mark", |screen| !screen.contents().contains("● not saved"));
    take_depth();
    session.press("Escape");
    session.wait("end of the adviser", |screen| !screen.contents().contains("saves"));
    assert_eq!(save(&session), ADVISED);
    leave(session);
}

const ADVISED: &str = r##"# a table for tests
[film]
width = 160                # small
height = 90

[camera]
position = [0, 1, 8]
look_at = [0, 0, 0]
fov = 40

[render]
samples = 1
max_depth = 0

[[light]]
name = "lamp"
position = [4, 6, 3]       # above

[[material]]
name = "paint"             # one of
color = "tomato"

[[object]]
name = "left"
shape = "sphere"
radius = 0.75              # round
translate = [-1, 0, 0]
material = "paint"

[[object]]
name = "right"
shape = "sphere"
radius = 0.75
translate = [1, 0, 0]
material = "paint"

[[object]]
name = "floor"
shape = "plane"
translate = [0, -1, 0]     # below
"##;

#[test]
fn keys_are_others_where_the_users_file_says_so() {
    let home = Path::new(env!("CARGO_TARGET_TMPDIR")).join("pty-editor-keys-home");
    fs::create_dir_all(home.join("glimt")).unwrap();
    fs::write(home.join("glimt/keys.toml"), "undo = \"Ctrl-U\"\nsave-scene = [\"S\"]\nhide-or-show = \"w\"\n").unwrap();
    let told = std::process::Command::new(env!("CARGO_BIN_EXE_glimt"))
        .arg("keys")
        .env("XDG_CONFIG_HOME", &home)
        .output()
        .unwrap();
    let told = String::from_utf8(told.stdout).unwrap();
    for wanted in ["Ctrl-U undo", "S save-scene", "w hide-or-show"] {
        let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(told.lines().any(|line| words(line) == wanted), "{wanted}\n{told}");
    }
    let session = Session::start_with("editor-keys", DESK, SCENE, |program| {
        let mut command = CommandBuilder::new(program);
        command.arg("ball.toml");
        command.env("XDG_CONFIG_HOME", &home);
        command
    });
    session.wait_for_status("saved ball.png");
    session.choose("left");
    session.press("w");
    session.wait_for_text("hidden sphere");
    session.press("u");
    session.wait_for_status("u does nothing here");
    session.send("\x15");
    session.wait_for_status("undone: hide");
    session.press("w");
    session.wait_for_text("hidden sphere");
    session.press("S");
    session.wait_for_status("saved ball.toml");
    assert_eq!(
        session.read("ball.toml"),
        with(&[("[-1, 0, 0]\nmaterial = \"paint\"\n", "[-1, 0, 0]\nmaterial = \"paint\"\nvisible = false\n")])
    );
    leave(session);
}

#[test]
fn what_changes_on_the_disk_is_reloaded_and_what_is_broken_is_told_beside_the_last_good_picture() {
    let scene = format!(
        "{SCENE}\n[[material]]\nname = \"cloth\"\ntexture = {{ file = \"cloth.png\" }}\n\
         [[object]]\nname = \"rug\"\nshape = \"quad\"\nsize = [20, 20]\ntranslate = [0, -0.99, 0]\nmaterial = \"cloth\"\n\
         [[object]]\nname = \"crate\"\nshape = \"mesh\"\nfile = \"box.obj\"\nscale = 0.5\ntranslate = [0, 0, -2]\n"
    );
    let mut session = Session::start("editor-reload", DESK, SCENE);
    session.wait_for_status("saved ball.png");
    furnish(&session);
    let write = |text: &str| fs::write(session.directory.join("ball.toml"), text).unwrap();
    write(&scene);
    session.wait_for_status("ball.toml has changed: reloaded");
    session.wait_for_text("crate");
    session.choose("left");
    session.press("i");
    session.wait_for_text("● not saved");
    // A picture.
    let green = image::RgbImage::from_pixel(4, 4, image::Rgb([0, 255, 0]));
    green.save(session.directory.join("cloth.png")).unwrap();
    session.wait("a green rug", |screen| has_color(screen, |r, g, b| g > 60 && r < g / 3 && b < g / 3));
    // A model.
    fs::write(session.directory.join("box.obj"), MODEL.replace("v 1 ", "v 3 ")).unwrap();
    session.wait_for_status("box.obj has changed");
    // A mistake, and away with it. The edit and the selection are there yet.
    write(&scene.replace("radius = 0.75              # round", "radus = 0.75"));
    session.wait_for_text("The file on the disk has mistakes");
    session.wait_for_text("radus");
    session.wait("picture", |screen| has_color(screen, |r, g, b| g > 60 && r < g / 3 && b < g / 3));
    write(&scene.replace("tomato", "gold"));
    session.wait("end of the mistakes", |screen| !screen.contents().contains("has mistakes"));
    session.wait_for_status("reloaded");
    assert!(below_the_tree(session.far().parser.screen()).contains("left"));
    // The picture is of this scene with the eye as it was moved: what is saved has the new colour and the old edit.
    let saved = save(&session);
    let file = session.directory.join("ball.toml");
    let mut wanted = parse(&scene.replace("tomato", "gold"), &file).unwrap();
    camera::dolly(&mut wanted.camera, 0.9);
    assert_eq!(parse(&saved, &file).unwrap(), wanted);
    session.press("q");
    assert_eq!(session.end(), 0);
}

#[test]
fn quitting_with_changes_asks_and_each_answer_does_what_it_says() {
    let mut session = start("quit");
    session.choose("left");
    session.press("v q");
    session.wait_for_text("changes that are not saved");
    session.press("Escape");
    session.wait("end of the question", |screen| !screen.contents().contains("changes that are not saved"));
    session.press("q");
    session.wait_for_text("changes that are not saved");
    session.press("q");
    assert_eq!(session.end(), 0);
    session.assert_restored();
    assert_eq!(session.read("ball.toml"), SCENE);
    let mut session = start("quit-save");
    session.choose("left");
    session.press("v q");
    session.wait_for_text("changes that are not saved");
    session.press("s");
    assert_eq!(session.end(), 0);
    session.assert_restored();
    assert_eq!(
        session.read("ball.toml"),
        with(&[("[-1, 0, 0]\nmaterial = \"paint\"\n", "[-1, 0, 0]\nmaterial = \"paint\"\nvisible = false\n")])
    );
}
