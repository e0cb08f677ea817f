//! What may have been meant by a name that does not exist.

use std::borrow::Cow;

/// Longest part of a name from the file that is repeated in a message, in characters.
const QUOTED: usize = 40;
/// Most names that are listed.
const LISTED: usize = 12;
/// How alike (Jaro and Winkler, 1 is equal) a name must be to be suggested.
const ALIKE: f64 = 0.8;

/// Words that people use for names of the language, where spelling does not lead from one to the other.
const SYNONYMS: &[(&str, &str)] = &[
    ("angle", "fov"),
    ("axis", "direction"),
    ("ball", "sphere"),
    ("bounces", "max_depth"),
    ("box", "cuboid"),
    ("center", "translate"),
    ("centre", "translate"),
    ("cube", "cuboid"),
    ("depth", "max_depth"),
    ("distance", "falloff"),
    ("down", "bottom"),
    ("exponent", "shininess"),
    ("eye", "position"),
    ("field_of_view", "fov"),
    ("fieldofview", "fov"),
    ("from", "position"),
    ("glossiness", "shininess"),
    ("image", "file"),
    ("image", "film"),
    ("picture", "film"),
    ("sphere", "object"),
    ("shape", "object"),
    ("cuboid", "object"),
    ("mesh", "object"),
    ("settings", "render"),
    ("environment", "world"),
    ("background", "world"),
    ("texture", "material"),
    ("index", "ior"),
    ("k_a", "ambient"),
    ("k_d", "diffuse"),
    ("k_r", "reflect"),
    ("k_s", "specular"),
    ("k_t", "transmit"),
    ("location", "position"),
    ("mirror", "reflect"),
    ("model", "mesh"),
    ("move", "translate"),
    ("obj", "mesh"),
    ("origin", "position"),
    ("origin", "translate"),
    ("path", "file"),
    ("position", "translate"),
    ("power", "intensity"),
    ("quadratic", "inverse-square"),
    ("rectangle", "quad"),
    ("refract", "transmit"),
    ("refraction", "transmit"),
    ("res", "width"),
    ("roughness", "shininess"),
    ("sky", "background"),
    ("sun", "directional"),
    ("target", "look_at"),
    ("tile", "repeat"),
    ("transparency", "transmit"),
    ("turn", "rotate"),
    ("type", "kind"),
    ("type", "shape"),
];

/// The one of `valid` that `wrong` most likely stands for, if any is likely.
pub(super) fn nearest<'n>(wrong: &str, valid: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    if wrong.len() > 4 * QUOTED {
        return None;
    }
    let wrong = wrong.to_lowercase();
    valid
        .into_iter()
        .map(|name| {
            let same = SYNONYMS.contains(&(wrong.as_str(), name));
            (if same { 1.0 } else { strsim::jaro_winkler(&wrong, &name.to_lowercase()) }, name)
        })
        .filter(|&(alike, _)| alike >= ALIKE)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// "did you mean `x`?", or `otherwise`.
pub(super) fn did_you_mean<'n>(wrong: &str, valid: impl IntoIterator<Item = &'n str>, otherwise: &str) -> String {
    nearest(wrong, valid).map_or_else(|| otherwise.to_owned(), |name| format!("did you mean {}?", quoted(name)))
}

/// A name from the file for use in a message.
pub(super) fn quoted(name: &str) -> String {
    format!("`{}`", shortened(name))
}

fn shortened(name: &str) -> Cow<'_, str> {
    match name.char_indices().nth(QUOTED) {
        None => Cow::Borrowed(name),
        Some((end, _)) => Cow::Owned(format!("{}…", &name[..end])),
    }
}

/// `a, b, c`, cut if there are many.
pub(super) fn list<'n>(names: impl IntoIterator<Item = &'n str>) -> String {
    let mut names = names.into_iter();
    let mut shown: Vec<_> = names.by_ref().take(LISTED).map(shortened).collect();
    if names.next().is_some() {
        shown.push(Cow::Borrowed("…"));
    }
    shown.join(", ")
}
