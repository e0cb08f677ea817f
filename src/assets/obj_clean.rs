//! The pass in front of tobj: reads OBJ text line by line, checks every number and index, and deals out text that tobj
//! reads right and fast; what tobj does not know (smoothing groups, lines, materials not yet loaded) is kept in an
//! [`Outline`].
//!
//! The text that comes out holds nothing but
//! - `v x y z`, `vt u v`, `vn x y z` with plain numbers;
//! - `f` with positive indices. One such line holds the corners of many faces: tobj need not know where a face ends,
//!   for the outline does, and so it allocates once a few hundred faces instead of once a face;
//! - `g`, which makes tobj start a new mesh. All corners of one mesh are of one [`Form`], because tobj makes up texture
//!   coordinates and normals where a mesh has them on some corners only; and a mesh is short, because tobj's table of
//!   corners is fast while it fits a cache.

use super::AssetError;
use super::obj_lines::{Line, Lines, Words, check_number, lossy, parse_number};
use std::collections::HashMap;
use std::io::{self, BufRead, Read};
use std::path::Path;

/// How a face wants its normals where the file gives none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Smoothing {
    /// `s off`: its own.
    Flat,
    /// Said nothing: smooth across edges that are not too sharp.
    Crease,
    /// `s`: smooth with all faces of the same object and group; groups are numbered from 0.
    Group(u32),
}

/// A face, in the order of the file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// How many corners; at least 3.
    pub corners: u32,
    /// Its line.
    pub line: u32,
    /// Index into [`Outline::materials`], or [`NO_MATERIAL`].
    pub material: u32,
    /// How it is to be smoothed.
    pub smoothing: Smoothing,
}

/// A face before any `usemtl`.
pub(super) const NO_MATERIAL: u32 = u32::MAX;

/// What the pass knows of a file and tobj does not.
#[derive(Default)]
pub(super) struct Outline {
    /// Faces of 3 corners and more.
    pub faces: Vec<Face>,
    /// Names in `usemtl` lines, the whole rest of each line.
    pub materials: Vec<Vec<u8>>,
    /// Names in `mtllib` lines, the whole rest of each line, each once.
    pub libraries: Vec<Vec<u8>>,
    /// `l` and `p` elements and faces of fewer than three corners.
    pub lines_and_points: usize,
    /// Statements of free-form curves and surfaces.
    pub free_form: usize,
    /// Vertices that carry colours.
    pub colored: usize,
    /// Vertices that carry a weight other than 1.
    pub weighted: usize,
    /// Lines with keywords that nobody knows, and the first of them.
    pub unknown: (usize, Option<(usize, String)>),
}

/// Which indices the corners of a face have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Form {
    texture: bool,
    normal: bool,
}

/// Indices of a corner into `v`, `vt` and `vn`, from 1; 0 where there is none.
type Corner = [u32; 3];

/// Reads cleaned text; see the module. An error of reading stands for one of the file, to be taken with
/// [`Cleaner::into_outline`].
pub(super) struct Cleaner<'a> {
    lines: Lines<'a>,
    state: State<'a>,
    sent: usize,
    finished: bool,
    error: Option<AssetError>,
}

/// Bytes made at a time.
const CHUNK: usize = 1 << 16;
/// Most different `mtllib` lines that are heeded.
const MAX_LIBRARIES: usize = 256;
/// Most corners of a face.
const FACE_CORNERS: usize = 1 << 20;
/// Corners in a line.
const LINE_CORNERS: usize = 1024;
/// Corners in a mesh.
const MESH_CORNERS: usize = 1 << 16;

impl<'a> Cleaner<'a> {
    /// Starts on the bytes of `file`.
    pub fn new(file: &'a Path, bytes: &'a [u8]) -> Result<Self, AssetError> {
        let state = State {
            file,
            out: Vec::with_capacity(CHUNK * 2),
            late: Vec::new(),
            outline: Outline::default(),
            counts: [0; 3],
            ahead: [(0, 0); 3],
            corners: Vec::new(),
            pending: Vec::new(),
            form: Form::default(),
            mesh_corners: 0,
            object: 0,
            group: None,
            smoothing: Smoothing::Crease,
            groups: HashMap::new(),
            material: NO_MATERIAL,
            material_numbers: HashMap::new(),
        };
        Ok(Self { lines: Lines::new(file, bytes)?, state, sent: 0, finished: false, error: None })
    }

    /// What was found on the way, or the first thing that is wrong with the file. To be called when all is read.
    pub fn into_outline(self) -> Result<Outline, AssetError> {
        self.error.map_or(Ok(self.state.outline), Err)
    }

    fn fill(&mut self) -> Result<(), AssetError> {
        self.state.out.clear();
        self.sent = 0;
        while self.state.out.len() < CHUNK && !self.finished {
            match self.lines.next() {
                Some(line) => self.state.line(&line)?,
                None => {
                    self.finished = true;
                    self.state.finish()?;
                }
            }
        }
        Ok(())
    }
}

impl BufRead for Cleaner<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.sent == self.state.out.len()
            && let Err(e) = self.fill()
        {
            self.error = Some(e);
            return Err(io::Error::other("see Cleaner::into_outline"));
        }
        Ok(&self.state.out[self.sent..])
    }

    fn consume(&mut self, amount: usize) {
        self.sent = (self.sent + amount).min(self.state.out.len());
    }
}

impl Read for Cleaner<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(buffer)?;
        self.consume(n);
        Ok(n)
    }
}

struct State<'a> {
    file: &'a Path,
    out: Vec<u8>,
    /// Face text kept until the end because some of it names vertices that were not yet seen.
    late: Vec<u8>,
    outline: Outline,
    /// `v`, `vt` and `vn` seen.
    counts: [u32; 3],
    /// Highest index beyond the counts at its line, and that line.
    ahead: [(u32, usize); 3],
    /// Corners of the face being read.
    corners: Vec<Corner>,
    /// Corners not written yet, all of `form`.
    pending: Vec<Corner>,
    form: Form,
    mesh_corners: usize,
    object: u32,
    /// Number in the last `s`.
    group: Option<u32>,
    smoothing: Smoothing,
    groups: HashMap<(u32, u32), u32>,
    material: u32,
    material_numbers: HashMap<Vec<u8>, u32>,
}

impl State<'_> {
    fn line(&mut self, line: &Line) -> Result<(), AssetError> {
        match line.keyword {
            b"v" => self.vertex(line),
            b"vt" => self.numbers(line, 1, 1, 2).map(drop),
            b"vn" => self.normal(line),
            b"f" | b"fo" => self.face(line),
            b"s" => {
                let word = Words(line.rest).next().unwrap_or_default();
                let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
                self.smooth(number.unwrap_or(u32::from(word.eq_ignore_ascii_case(b"on"))));
                Ok(())
            }
            b"usemtl" => {
                self.use_material(line.rest);
                Ok(())
            }
            b"mtllib" => {
                let libraries = &mut self.outline.libraries;
                if libraries.len() < MAX_LIBRARIES && !libraries.iter().any(|known| known == line.rest) {
                    libraries.push(line.rest.to_vec());
                }
                Ok(())
            }
            b"o" => {
                // The group number goes on, but nothing is smoothed across objects.
                self.object += 1;
                if let Some(group) = self.group {
                    self.smooth(group);
                }
                Ok(())
            }
            b"l" | b"p" => {
                self.outline.lines_and_points += 1;
                Ok(())
            }
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm" | b"trim"
            | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"bzp" | b"bsp" | b"cdc" | b"cdp" | b"res" => {
                self.outline.free_form += 1;
                Ok(())
            }
            b"g" | b"mg" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"usemap" | b"maplib" | b"shadow_obj"
            | b"trace_obj" | b"ctech" | b"stech" => Ok(()),
            _ => {
                let (count, first) = &mut self.outline.unknown;
                *count += 1;
                first.get_or_insert_with(|| (line.number, lossy(line.keyword)));
                Ok(())
            }
        }
    }

    fn refuse<T>(&self, line: usize, reason: String) -> Result<T, AssetError> {
        Err(AssetError::new(self.file, Some(line), reason))
    }

    /// `v x y z`, then nothing, a weight (which matters to free-form surfaces only), or colours.
    fn vertex(&mut self, line: &Line) -> Result<(), AssetError> {
        let extra = self.numbers(line, 0, 3, 3)?;
        if extra.is_empty() {
            return Ok(());
        }
        let (mut count, mut first) = (0, 1.0);
        for word in Words(extra) {
            match parse_number(word) {
                Some(value) if count == 0 => first = value,
                Some(_) => {}
                None => return self.refuse(line.number, format!("`{}` is not a number", lossy(word))),
            }
            count += 1;
        }
        self.outline.colored += usize::from(count >= 3);
        self.outline.weighted += usize::from(count == 1 && first != 1.0);
        Ok(())
    }

    /// A line of `least` to `most` numbers for list `kind`, 0 standing for each missing one. Returns what follows them.
    #[inline]
    fn numbers<'l>(&mut self, line: &Line<'l>, kind: usize, least: usize, most: usize) -> Result<&'l [u8], AssetError> {
        self.out.extend_from_slice(KEYWORDS[kind]);
        let mut words = Words(line.rest);
        let mut count = 0;
        for word in words.by_ref().take(most) {
            if let Err(reason) = check_number(word) {
                return self.refuse(line.number, reason);
            }
            self.out.push(b' ');
            self.out.extend_from_slice(word);
            count += 1;
        }
        if count < least {
            let keyword = lossy(line.keyword);
            return self.refuse(line.number, format!("`{keyword}` needs {least} numbers and has {count}"));
        }
        for _ in count..most {
            self.out.extend_from_slice(b" 0");
        }
        self.out.push(b'\n');
        self.counts[kind] += 1;
        Ok(words.0)
    }

    /// `vn`. Exporters write nan for the normal of a degenerate face; 0 0 0 makes it computed.
    fn normal(&mut self, line: &Line) -> Result<(), AssetError> {
        let is_useless = |word: &[u8]| {
            check_number(word).is_err() && (parse_number(word).is_some() || word.windows(2).any(|w| w == b".#"))
        };
        let rest = if Words(line.rest).take(3).any(is_useless) { b"0 0 0" } else { line.rest };
        self.numbers(&Line { rest, ..*line }, 2, 3, 3).map(drop)
    }

    fn face(&mut self, line: &Line) -> Result<(), AssetError> {
        self.corners.clear();
        let mut form = Form { texture: true, normal: true };
        for word in Words(line.rest) {
            let corner = match self.corner(word, line.number) {
                Ok(corner) => corner,
                Err(reason) => return self.refuse(line.number, reason),
            };
            form.texture &= corner[1] != 0;
            form.normal &= corner[2] != 0;
            self.corners.push(corner);
        }
        let corners = self.corners.len();
        if corners < 3 {
            self.outline.lines_and_points += 1;
            return Ok(());
        }
        if corners > FACE_CORNERS {
            return self.refuse(line.number, format!("a face of {corners} corners; at most {FACE_CORNERS}: split it"));
        }
        if form != self.form || self.mesh_corners >= MESH_CORNERS {
            self.end_mesh();
        }
        self.form = form;
        self.mesh_corners += corners;
        self.pending.append(&mut self.corners);
        if self.pending.len() >= LINE_CORNERS {
            self.write_pending();
        }
        self.outline.faces.push(Face {
            corners: corners as u32,
            line: line.number as u32,
            material: self.material,
            smoothing: self.smoothing,
        });
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative indices count back from the last one.
    #[inline]
    fn corner(&mut self, word: &[u8], line: usize) -> Result<Corner, String> {
        let mut corner = [0; 3];
        let mut rest = word;
        for kind in 0..3 {
            let (negative, digits) = match rest {
                [b'-', digits @ ..] => (true, digits),
                _ => (false, rest),
            };
            let mut index = 0_u64;
            let mut length = 0;
            while let Some(d @ b'0'..=b'9') = digits.get(length) {
                // Saturates far beyond any count.
                index = (index * 10 + u64::from(d - b'0')).min(1 << 40);
                length += 1;
            }
            let count = u64::from(self.counts[kind]);
            if length == 0 {
                if kind == 0 || negative {
                    return Err(format!("`{}` is not a corner of a face", lossy(word)));
                }
            } else if index == 0 {
                return Err(format!("`{}`: indices start at 1", lossy(word)));
            } else if negative {
                if index > count {
                    return Err(format!("`{}`: only {count} {} so far", lossy(word), NOUNS[kind]));
                }
                corner[kind] = (count + 1 - index) as u32;
            } else {
                corner[kind] = index.min(u64::from(u32::MAX)) as u32;
                if index > count && corner[kind] > self.ahead[kind].0 {
                    self.ahead[kind] = (corner[kind], line);
                }
            }
            match digits.get(length) {
                None => return Ok(corner),
                Some(b'/') if kind < 2 => rest = &digits[length + 1..],
                Some(_) => break,
            }
        }
        Err(format!("`{}` is not a corner of a face", lossy(word)))
    }

    fn smooth(&mut self, group: u32) {
        self.group = Some(group);
        self.smoothing = if group == 0 {
            Smoothing::Flat
        } else {
            let next = self.groups.len() as u32;
            Smoothing::Group(*self.groups.entry((self.object, group)).or_insert(next))
        };
    }

    fn use_material(&mut self, name: &[u8]) {
        self.material = match self.material_numbers.get(name) {
            _ if name.is_empty() => NO_MATERIAL,
            Some(&number) => number,
            None => {
                let number = self.outline.materials.len() as u32;
                self.material_numbers.insert(name.to_vec(), number);
                self.outline.materials.push(name.to_vec());
                number
            }
        };
    }

    /// Writes the pending corners as one face.
    fn write_pending(&mut self) {
        if self.pending.is_empty() {
            return;
        }
        let form = self.form;
        let out = if self.looks_ahead() { &mut self.late } else { &mut self.out };
        out.push(b'f');
        for [v, vt, vn] in self.pending.drain(..) {
            out.push(b' ');
            push_number(out, v);
            if form.texture {
                out.push(b'/');
                push_number(out, vt);
            }
            if form.normal {
                out.extend_from_slice(if form.texture { b"/" } else { b"//" });
                push_number(out, vn);
            }
        }
        out.push(b'\n');
    }

    /// Whether some corner was ahead of the vertices when it was read. tobj looks corners up at the end of a mesh, so
    /// from then on it is given no face before the last vertex.
    fn looks_ahead(&self) -> bool {
        self.ahead != [(0, 0); 3]
    }

    /// Starts a new mesh.
    fn end_mesh(&mut self) {
        self.write_pending();
        self.mesh_corners = 0;
        if self.looks_ahead() { &mut self.late } else { &mut self.out }.extend_from_slice(b"g\n");
    }

    fn finish(&mut self) -> Result<(), AssetError> {
        self.write_pending();
        for (kind, &(index, line)) in self.ahead.iter().enumerate() {
            let count = self.counts[kind];
            if index > count {
                return self.refuse(line, format!("index {index} is too high: the file has {count} {}", NOUNS[kind]));
            }
        }
        self.out.append(&mut self.late);
        Ok(())
    }
}

const KEYWORDS: [&[u8]; 3] = [b"v", b"vt", b"vn"];
const NOUNS: [&str; 3] = ["vertices", "texture coordinates", "normals"];

fn push_number(out: &mut Vec<u8>, mut value: u32) {
    let mut digits = [0; 10];
    let mut at = digits.len();
    loop {
        at -= 1;
        digits[at] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[at..]);
}
