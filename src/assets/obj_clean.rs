//! The pass in front of tobj: reads a part of OBJ text line by line, checks every number and index, and deals out text
//! that tobj reads right and fast; what tobj need not know (faces, smoothing groups, materials) is kept in [`Found`].
//!
//! The text that comes out holds nothing but `v x y z`, `vt u v`, `vn x y z` with plain numbers, and at its end one `f`
//! that names each of them in turn, for tobj gives out only what faces use. The faces themselves have been read here,
//! where their indices had to be checked: to write them anew for tobj took half of the time of loading.

use super::AssetError;
use super::obj_lines::{Line, Lines, Words, are_plain, check_number, lossy, parse_number};
use std::io::{self, BufRead, Read};
use std::path::Path;

/// A face of 3 corners and more.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Its first corner; the first of the next face ends it.
    pub start: u32,
    /// Its line.
    pub line: u32,
}

/// The corners of faces, one after another: indices from 1 into the vertices, texture coordinates and normals of the
/// whole file, 0 where a face does not have them on all of its corners.
#[derive(Debug, Default)]
pub(super) struct Corners {
    pub places: Vec<u32>,
    /// Empty if no face has any.
    pub uvs: Vec<u32>,
    /// Empty if no face has any.
    pub normals: Vec<u32>,
}

/// A line that concerns the faces after it.
#[derive(Debug)]
pub(super) enum Change {
    /// `usemtl`: the whole rest of the line.
    Material(Vec<u8>),
    /// `s`: the group, 0 for none.
    Smoothing(u32),
    /// `o`
    Object,
}

/// What the pass finds beside the numbers of vertices.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// How many `v`, `vt` and `vn`.
    pub vertices: [u32; 3],
    /// In the order of the file.
    pub faces: Vec<Face>,
    pub corners: Corners,
    /// Changes and how many faces stand before them.
    pub changes: Vec<(u32, Change)>,
    /// Highest index into `v`, `vt` and `vn`, and its first line.
    pub highest: [(u32, usize); 3],
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

/// Counts of what stands before a part of a file.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Before {
    /// Physical lines.
    pub lines: usize,
    /// `v`, `vt` and `vn`.
    pub vertices: [u32; 3],
}

impl Before {
    /// What stands in a part.
    pub fn count(mut lines: Lines) -> Self {
        let mut vertices = [0; 3];
        while let Some(line) = lines.next() {
            match line.keyword {
                b"v" => vertices[0] += 1,
                b"vt" => vertices[1] += 1,
                b"vn" => vertices[2] += 1,
                _ => {}
            }
        }
        Self { lines: lines.number, vertices }
    }

    /// What stands before the part after one with these counts.
    pub fn and(self, part: Self) -> Self {
        let vertices = std::array::from_fn(|kind| self.vertices[kind] + part.vertices[kind]);
        Self { lines: self.lines + part.lines, vertices }
    }
}

/// Reads cleaned text; see the module. An error of reading stands for one of the file, to be taken with
/// [`Cleaner::into_found`].
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
pub(super) const MAX_LIBRARIES: usize = 256;
/// Most corners of a face.
const FACE_CORNERS: usize = 1 << 20;

impl<'a> Cleaner<'a> {
    /// Starts on a part of `file`.
    pub fn new(file: &'a Path, mut lines: Lines<'a>, before: Before) -> Self {
        lines.number = before.lines;
        let state = State {
            file,
            out: Vec::with_capacity(CHUNK * 2),
            before: before.vertices,
            found: Found::default(),
            face: Vec::new(),
        };
        Self { lines, state, sent: 0, finished: false, error: None }
    }

    /// What was found on the way, or the first thing that is wrong with the part. To be called when all is read.
    pub fn into_found(self) -> Result<Found, AssetError> {
        self.error.map_or(Ok(self.state.found), Err)
    }

    fn fill(&mut self) -> Result<(), AssetError> {
        self.state.out.clear();
        self.sent = 0;
        while self.state.out.len() < CHUNK && !self.finished {
            match self.lines.next() {
                Some(line) => self.state.line(&line)?,
                None => {
                    self.finished = true;
                    self.state.finish();
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
            return Err(io::Error::other("see Cleaner::into_found"));
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

/// Indices of a corner into `v`, `vt` and `vn`, from 1; 0 where there is none.
type Corner = [u32; 3];

struct State<'a> {
    file: &'a Path,
    out: Vec<u8>,
    /// `v`, `vt` and `vn` before this part.
    before: [u32; 3],
    found: Found,
    /// Corners of the face being read.
    face: Vec<Corner>,
}

impl State<'_> {
    fn line(&mut self, line: &Line) -> Result<(), AssetError> {
        match line.keyword {
            b"v" => self.vertex(line),
            b"vt" => self.numbers(line, 1, 1, 2).map(drop),
            b"vn" => self.normal(line),
            b"f" | b"fo" => self.face(line),
            _ => {
                self.statement(line);
                Ok(())
            }
        }
    }

    fn statement(&mut self, line: &Line) {
        let Found { faces, changes, libraries, .. } = &mut self.found;
        let mut change = |change| changes.push((faces.len() as u32, change));
        match line.keyword {
            b"s" => {
                let word = Words(line.rest).next().unwrap_or_default();
                let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
                change(Change::Smoothing(number.unwrap_or(u32::from(word.eq_ignore_ascii_case(b"on")))));
            }
            b"usemtl" => change(Change::Material(line.rest.to_vec())),
            b"o" => change(Change::Object),
            b"mtllib" => {
                if libraries.len() < MAX_LIBRARIES && !libraries.iter().any(|known| known == line.rest) {
                    libraries.push(line.rest.to_vec());
                }
            }
            b"l" | b"p" => self.found.lines_and_points += 1,
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm" | b"trim"
            | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"bzp" | b"bsp" | b"cdc" | b"cdp" | b"res" => {
                self.found.free_form += 1;
            }
            b"g" | b"mg" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"usemap" | b"maplib" | b"shadow_obj"
            | b"trace_obj" | b"ctech" | b"stech" => {}
            _ => {
                let (count, first) = &mut self.found.unknown;
                *count += 1;
                first.get_or_insert_with(|| (line.number, lossy(line.keyword)));
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
        self.found.colored += usize::from(count >= 3);
        self.found.weighted += usize::from(count == 1 && first != 1.0);
        Ok(())
    }

    /// A line of `least` to `most` numbers for list `kind`, 0 standing for each missing one. Returns what follows them.
    #[inline]
    fn numbers<'l>(&mut self, line: &Line<'l>, kind: usize, least: usize, most: usize) -> Result<&'l [u8], AssetError> {
        self.out.extend_from_slice(KEYWORDS[kind]);
        if are_plain(line.rest, most) {
            self.out.push(b' ');
            self.out.extend_from_slice(line.rest);
            self.out.push(b'\n');
            self.found.vertices[kind] += 1;
            return Ok(&[]);
        }
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
        self.found.vertices[kind] += 1;
        Ok(words.0)
    }

    /// `vn`. Exporters write nan for the normal of a degenerate face; 0 0 0 makes it computed.
    fn normal(&mut self, line: &Line) -> Result<(), AssetError> {
        if are_plain(line.rest, 3) {
            return self.numbers(line, 2, 3, 3).map(drop);
        }
        let is_useless = |word: &[u8]| {
            check_number(word).is_err() && (parse_number(word).is_some() || word.windows(2).any(|w| w == b".#"))
        };
        let rest = if Words(line.rest).take(3).any(is_useless) { b"0 0 0" } else { line.rest };
        self.numbers(&Line { rest, ..*line }, 2, 3, 3).map(drop)
    }

    fn face(&mut self, line: &Line) -> Result<(), AssetError> {
        self.face.clear();
        let (mut has_uvs, mut has_normals) = (true, true);
        let mut words = Words(line.rest);
        let mut highest = [0; 3];
        loop {
            let corner = if let Some((corner, rest)) = plain_corner(words.0) {
                words.0 = rest;
                highest = std::array::from_fn(|kind| corner[kind].max(highest[kind]));
                corner
            } else {
                let Some(word) = words.next() else { break };
                match self.corner(word, line.number) {
                    Ok(corner) => corner,
                    Err(reason) => return self.refuse(line.number, reason),
                }
            };
            has_uvs &= corner[1] != 0;
            has_normals &= corner[2] != 0;
            self.face.push(corner);
        }
        for (index, highest) in highest.into_iter().zip(&mut self.found.highest) {
            if index > highest.0 {
                *highest = (index, line.number);
            }
        }
        let count = self.face.len();
        if count < 3 {
            self.found.lines_and_points += 1;
            return Ok(());
        }
        if count > FACE_CORNERS {
            return self.refuse(line.number, format!("a face of {count} corners; at most {FACE_CORNERS}: split it"));
        }
        let Corners { places, uvs, normals } = &mut self.found.corners;
        let start = places.len();
        places.extend(self.face.iter().map(|corner| corner[0]));
        if has_uvs {
            uvs.resize(start, 0);
            uvs.extend(self.face.iter().map(|corner| corner[1]));
        }
        if has_normals {
            normals.resize(start, 0);
            normals.extend(self.face.iter().map(|corner| corner[2]));
        }
        self.found.faces.push(Face { start: start as u32, line: line.number as u32 });
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`; negative indices count back from the last one.
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
            let count = u64::from(self.before[kind] + self.found.vertices[kind]);
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
                if corner[kind] > self.found.highest[kind].0 {
                    self.found.highest[kind] = (corner[kind], line);
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

    /// Ends the text with a face of every vertex, texture coordinate and normal, for which tobj is told to keep lists
    /// apart from each other. A shorter list goes on with its last.
    fn finish(&mut self) {
        let Corners { places, uvs, normals } = &mut self.found.corners;
        for list in [uvs, normals] {
            if !list.is_empty() {
                list.resize(places.len(), 0);
            }
        }
        let [v, vt, vn] = self.found.vertices;
        if v == 0 && vt.max(vn) > 0 {
            // A corner is no corner without a vertex.
            self.out.extend_from_slice(b"v 0 0 0\n");
        }
        self.out.push(b'f');
        for index in 1..=v.max(vt).max(vn) {
            self.out.push(b' ');
            push_number(&mut self.out, index.min(v.max(1)));
            if vt.max(vn) > 0 {
                self.out.push(b'/');
            }
            if vt > 0 {
                push_number(&mut self.out, index.min(vt));
            }
            if vn > 0 {
                self.out.push(b'/');
                push_number(&mut self.out, index.min(vn));
            }
        }
        self.out.push(b'\n');
    }
}

/// The corner at the start of `text` and what follows it, if it is of the kind that nearly all are: positive indices of
/// few digits.
#[inline]
fn plain_corner(mut text: &[u8]) -> Option<(Corner, &[u8])> {
    while let [b' ', rest @ ..] = text {
        text = rest;
    }
    let mut corner = [0; 3];
    let mut kind = 0;
    loop {
        let mut length = 0;
        let mut index = 0_u32;
        while let Some(d @ b'0'..=b'9') = text.get(length)
            && length < 9
        {
            index = index * 10 + u32::from(d - b'0');
            length += 1;
        }
        // Nothing between slashes is no index; 0 is none, but wrong.
        if index == 0 && (length > 0 || kind == 0) {
            return None;
        }
        corner[kind] = index;
        text = &text[length..];
        match text {
            [] | [b' ', ..] => return Some((corner, text)),
            [b'/', rest @ ..] if kind < 2 => text = rest,
            _ => return None,
        }
        kind += 1;
    }
}

const KEYWORDS: [&[u8]; 3] = [b"v", b"vt", b"vn"];
pub(super) const NOUNS: [&str; 3] = ["vertices", "texture coordinates", "normals"];

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
