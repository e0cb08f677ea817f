//! MTL libraries to materials of the scene language.
//!
//! As with OBJ, a pass in front of tobj hands it only what it reads right; what it does not know (`Tr`, `Tf`, options
//! of maps) is kept beside it. A line that cannot be used costs itself, not the library.
//!
//! # The mapping
//!
//! | MTL | material |
//! |---|---|
//! | `Kd` | `color` = Kd over its largest channel, `diffuse` = that channel; numbers are linear |
//! | `Ka` | `ambient` = 0.1 of the smaller of the largest channels of Ka and Kd: files mean a dim ambient light and often say 1, ours is white |
//! | `Ks` | `specular` = its largest channel (highlights are white); `reflect` too with illum 3 to 7 |
//! | `Ns`, `Ni` | `shininess` (at least 1), `ior` |
//! | `d`, `Tr` | `transmit` = 1 - d with illum 4, 6, 7; what passes is not scattered too: diffuse and ambient by d |
//! | `Tf` | `transmit` with illum 6 and 7 where there is no `d`: exporters write it with 4 for opaque things |
//! | `illum` | 0: the colour only; 1: no highlight; 5, 7: Fresnel; 8 to 10: as 2 |
//! | `map_Kd` | `texture`; `diffuse` from Kd, 1 if that is missing or black |

use super::obj_lines::{Line, Lines, Words, check_number, is_blank, lossy, parse_number, trim, without_comment};
use super::report::{counted, listed};
use super::resolve::Resolver;
use super::{AssetError, guard, read_file};
use crate::description::{MaterialDesc, TextureDesc, TextureSource, Wrap};
use crate::math::Rgb;
use glam::DVec2;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

/// Largest library, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// The materials of all libraries of a model.
#[derive(Default)]
pub(super) struct Materials {
    /// In the order of the files.
    all: Vec<MaterialDesc>,
    /// By name as written, and by name without what may be a comment. The first of a name counts.
    by_name: HashMap<Vec<u8>, usize>,
    by_short_name: HashMap<Vec<u8>, usize>,
    /// Lines that could not be used, one sentence each, of the first few; and how many there are in all.
    mistakes: (Vec<String>, usize),
    /// Names of pictures that were not found.
    missing_textures: BTreeSet<String>,
    /// Remarks: what, and the names of the materials or maps.
    remarks: BTreeMap<&'static str, BTreeSet<String>>,
}

/// What tobj does not know of a material.
#[derive(Default)]
struct Extra {
    name: Vec<u8>,
    transparency: Option<f64>,
    filter: Option<f64>,
    map: Map,
}

/// Options of a map, and its name as written.
struct Map {
    name: Vec<u8>,
    scale: DVec2,
    offset: DVec2,
    wrap: Wrap,
}

impl Default for Map {
    fn default() -> Self {
        Self { name: Vec::new(), scale: DVec2::ONE, offset: DVec2::ZERO, wrap: Wrap::Repeat }
    }
}

impl Materials {
    /// Adds the materials of a library.
    pub fn load(&mut self, file: &Path, resolver: &mut Resolver) -> Result<(), AssetError> {
        let bytes = read_file(file, MAX_BYTES)?;
        let (text, extras) = self.clean(file, &bytes)?;
        let read = guard(|| tobj::load_mtl_buf(&mut text.as_bytes()));
        let Some(Ok((read, _))) = read.filter(|r| r.as_ref().is_ok_and(|(m, _)| m.len() == extras.len())) else {
            return Err(AssetError::new(file, None, "cannot be read as MTL"));
        };
        for (material, extra) in read.into_iter().zip(extras) {
            let number = self.all.len();
            self.by_short_name.entry(without_comment(&extra.name).to_vec()).or_insert(number);
            self.by_name.entry(extra.name.clone()).or_insert(number);
            let made = self.make(file, material, extra, resolver);
            self.all.push(made);
        }
        Ok(())
    }

    /// The material that a `usemtl` line names.
    pub fn find(&self, name: &[u8]) -> Option<&MaterialDesc> {
        let short = || self.by_short_name.get(without_comment(name));
        self.by_name.get(name).or_else(short).and_then(|&number| self.all.get(number))
    }

    /// What a person should know of it, one sentence each.
    pub fn notes(self) -> Vec<String> {
        let mut notes = Vec::new();
        if !self.missing_textures.is_empty() {
            let names = &self.missing_textures;
            notes.push(format!("{} not found: {}", counted(names.len(), "texture"), listed(names)));
        }
        let (mistakes, count) = &self.mistakes;
        if *count > 0 {
            notes.push(format!("{} of material libraries ignored: {}", counted(*count, "line"), listed(mistakes)));
        }
        notes.extend(self.remarks.iter().map(|(what, whose)| format!("{what}: {}", listed(whose))));
        notes
    }

    fn remark(&mut self, what: &'static str, whose: &str) {
        self.remarks.entry(what).or_default().insert(whose.to_owned());
    }

    /// Text that tobj reads right, and what it leaves out.
    fn clean(&mut self, file: &Path, bytes: &[u8]) -> Result<(String, Vec<Extra>), AssetError> {
        let mut lines = Lines::new(file, bytes)?;
        let (mut text, mut extras) = (String::new(), Vec::new());
        while let Some(line) = lines.next() {
            if let Err(reason) = self.line(&line, &mut text, &mut extras) {
                let name = file.file_name().unwrap_or_default().to_string_lossy();
                self.mistakes.1 += 1;
                if self.mistakes.0.len() < 5 {
                    self.mistakes.0.push(format!("{name}:{}: {reason}", line.number));
                }
            }
        }
        Ok((text, extras))
    }

    fn line(&mut self, line: &Line, text: &mut String, extras: &mut Vec<Extra>) -> Result<(), String> {
        let keyword = line.keyword.to_ascii_lowercase();
        if keyword == b"newmtl" {
            if line.rest.is_empty() {
                return Err("a material without a name".to_owned());
            }
            text.push_str(&format!("newmtl {}\n", String::from_utf8_lossy(line.rest)));
            extras.push(Extra { name: line.rest.to_vec(), ..Extra::default() });
            return Ok(());
        }
        let Some(extra) = extras.last_mut() else {
            return Err(format!("`{}` before the first newmtl", lossy(line.keyword)));
        };
        let mut words = Words(line.rest);
        let mut color = |keyword: &str| {
            let [r, g, b] = color(line.rest)?;
            text.push_str(&format!("{keyword} {r} {g} {b}\n"));
            Ok(())
        };
        match keyword.as_slice() {
            b"ka" => return color("Ka"),
            b"kd" => return color("Kd"),
            b"ks" => return color("Ks"),
            b"tf" => {
                let [r, g, b] = self::color(line.rest)?;
                extra.filter = Some(r.max(g).max(b));
            }
            b"ke" => {
                let glows = self::color(line.rest)?.iter().any(|&v| v > 0.0);
                let name = lossy(&extra.name);
                if glows {
                    self.remark("emission (Ke) not supported", &name);
                }
            }
            b"ns" => text.push_str(&format!("Ns {}\n", number(words.next())?)),
            b"ni" => text.push_str(&format!("Ni {}\n", number(words.next())?)),
            b"d" => {
                let mut word = words.next();
                let halo = word.is_some_and(|w| w.eq_ignore_ascii_case(b"-halo"));
                if halo {
                    word = words.next();
                }
                text.push_str(&format!("d {}\n", number(word)?));
                let name = lossy(&extra.name);
                if halo {
                    self.remark("d -halo taken as d", &name);
                }
            }
            b"tr" => extra.transparency = Some(number(words.next())?),
            b"illum" => {
                let illum = number(words.next())?.round();
                if !(0.0..=10.0).contains(&illum) {
                    return Err(format!("there is no illum {illum}"));
                }
                text.push_str(&format!("illum {illum}\n"));
            }
            b"map_kd" => {
                let map = map(line.rest);
                if map.name.is_empty() {
                    return Err("map_Kd without a file name".to_owned());
                }
                text.push_str(&format!("map_Kd {}\n", String::from_utf8_lossy(&map.name)));
                extra.map = map;
            }
            // Mostly the same picture as map_Kd.
            b"map_ka" => {}
            b"bump" | b"disp" | b"decal" | b"refl" | b"norm" => {
                self.remark("maps other than map_Kd not supported", &lossy(line.keyword));
            }
            other if other.starts_with(b"map_") && other != b"map_aat" => {
                self.remark("maps other than map_Kd not supported", &lossy(line.keyword));
            }
            _ => {}
        }
        Ok(())
    }

    fn make(&mut self, file: &Path, read: tobj::Material, extra: Extra, resolver: &mut Resolver) -> MaterialDesc {
        let name = read.name;
        let mut made = MaterialDesc { name: name.clone(), ..MaterialDesc::default() };
        let largest = |color: [f64; 3]| color[0].max(color[1]).max(color[2]).clamp(0.0, 1.0);
        let illum = read.illumination_model.unwrap_or(2);

        if let Some(written) = read.diffuse_texture {
            made.texture = self.texture(file, &written, extra.map, resolver);
        }
        let kd = match read.diffuse {
            // Some exporters write black beside a texture.
            None | Some([0.0, 0.0, 0.0]) if made.texture.is_some() => Some([1.0; 3]),
            kd => kd,
        };
        if let Some(kd) = kd {
            let top = largest(kd);
            let scale = kd[0].max(kd[1]).max(kd[2]);
            let [r, g, b] = kd.map(|v| if scale > 0.0 { v.max(0.0) / scale } else { 0.0 });
            made.color = Rgb::new(r, g, b);
            made.diffuse = top;
            made.ambient = 0.1 * top;
            if made.texture.is_some() && (r < 1.0 || g < 1.0 || b < 1.0) {
                self.remark("texture not tinted by Kd", &name);
            }
        }
        if let Some(ka) = read.ambient {
            made.ambient = made.ambient.min(0.1 * largest(ka));
        }
        made.specular = if illum == 1 { 0.0 } else { largest(read.specular.unwrap_or_default()) };
        made.shininess = read.shininess.map_or(made.shininess, |ns| ns.max(1.0));
        made.ior = read.optical_density.filter(|&ni| ni > 0.0).unwrap_or(made.ior);

        let dissolve = read.dissolve.or(extra.transparency.map(|tr| 1.0 - tr)).map(|d| d.clamp(0.0, 1.0));
        match illum {
            0 => {
                made.color = made.color * made.diffuse;
                (made.ambient, made.diffuse, made.specular) = (1.0, 0.0, 0.0);
            }
            3..=7 => made.reflect = made.specular,
            10 => self.remark("illum 10 (shadow catcher) taken as 2", &name),
            _ => {}
        }
        if matches!(illum, 4 | 6 | 7) {
            let filter = extra.filter.filter(|_| illum != 4).map(|f| f.clamp(0.0, 1.0));
            made.transmit = dissolve.map(|d| 1.0 - d).or(filter).unwrap_or(0.0);
            made.diffuse *= 1.0 - made.transmit;
            made.ambient *= 1.0 - made.transmit;
        } else if dissolve.is_some_and(|d| d < 1.0) {
            self.remark("opaque in spite of d (only illum 4, 6 and 7 transmit)", &name);
        }
        made.fresnel = matches!(illum, 5 | 7);
        if made.fresnel {
            // The sum is divided by Fresnel's equations and must not exceed the light.
            made.reflect = made.reflect.min(1.0 - made.transmit);
        }
        made
    }

    fn texture(&mut self, library: &Path, written: &str, map: Map, resolver: &mut Resolver) -> Option<TextureDesc> {
        let short = String::from_utf8_lossy(without_comment(&map.name));
        let found = resolver.find(written, library).or_else(|| resolver.find(&short, library));
        if found.is_none() {
            self.missing_textures.insert(short.into_owned());
        }
        let source = TextureSource::Image { file: found?, wrap: map.wrap };
        Some(TextureDesc { source, scale: map.scale, offset: map.offset })
    }
}

fn number(word: Option<&[u8]>) -> Result<f64, String> {
    let word = word.ok_or("a number is missing")?;
    check_number(word)?;
    parse_number(word).ok_or_else(|| format!("`{}` is not a number", lossy(word)))
}

/// Three numbers, or one for all three.
fn color(rest: &[u8]) -> Result<[f64; 3], String> {
    let mut words = Words(rest).take(3);
    let first = words.next();
    if let Some(kind @ (b"spectral" | b"xyz")) = first {
        return Err(format!("{} colours are not supported", lossy(kind)));
    }
    let r = number(first)?;
    let g = words.next().map_or(Ok(r), |w| number(Some(w)))?;
    let b = words.next().map_or(Ok(r), |w| number(Some(w)))?;
    Ok([r, g, b])
}

/// `[options] name`; the name may have blanks and stand in quotes.
fn map(rest: &[u8]) -> Map {
    let mut map = Map::default();
    let mut rest = trim(rest);
    while let [b'-', ..] = rest {
        let (option, mut after) = first_word(rest);
        // Up to this many words belong to the option, as long as they are numbers.
        let (words, all_numbers) = match option.to_ascii_lowercase().as_slice() {
            b"-s" | b"-o" | b"-t" => (3, true),
            b"-mm" => (2, true),
            b"-bm" | b"-boost" | b"-texres" => (1, true),
            b"-clamp" | b"-blendu" | b"-blendv" | b"-cc" | b"-imfchan" | b"-type" | b"-colorspace" => (1, false),
            _ => break,
        };
        let mut values = Vec::new();
        let mut on = false;
        for _ in 0..words {
            let (word, behind) = first_word(after);
            match number(Some(word)) {
                Ok(value) => values.push(value),
                Err(_) if all_numbers => break,
                Err(_) => on = word.eq_ignore_ascii_case(b"on"),
            }
            after = behind;
        }
        let pair = |default: f64| {
            DVec2::new(values.first().copied().unwrap_or(default), values.get(1).copied().unwrap_or(default))
        };
        match option.to_ascii_lowercase().as_slice() {
            b"-s" => map.scale = pair(1.0),
            b"-o" => map.offset = pair(0.0),
            b"-clamp" => map.wrap = if on { Wrap::Clamp } else { Wrap::Repeat },
            _ => {}
        }
        rest = after;
    }
    if let [quote @ (b'"' | b'\''), inner @ .., last] = rest
        && quote == last
    {
        rest = inner;
    }
    map.name = trim(rest).to_vec();
    map
}

fn first_word(text: &[u8]) -> (&[u8], &[u8]) {
    let end = text.iter().position(|&b| is_blank(b)).unwrap_or(text.len());
    (&text[..end], trim(&text[end..]))
}
