//! The files that are built into the program, so it works from any folder. `preset:NAME` names them.

use crate::workspace::file_kind::FileKind;

/// The session that opens if none is named.
pub const DEFAULT_SESSION: &str = "default";

/// A built-in file.
#[derive(Debug)]
pub struct Preset {
    /// Its name, without `preset:`.
    pub name: &'static str,
    /// What it shows or describes: one line, for lists and menus.
    pub about: &'static str,
    text: &'static str,
}

macro_rules! files {
    ($folder:literal, $suffix:literal: $($name:literal = $about:literal),* $(,)?) => {
        &[$(Preset {
            name: $name,
            about: $about,
            text: include_str!(concat!("../../presets/", $folder, "/", $name, ".", $suffix)),
        },)*]
    };
}

// The files, in the order of menus and lists.
const FORMULAS: &[Preset] = files!("formula", "formula":
    "phong" = "Phong (1975): matte, with a highlight around the mirror direction",
    "phong-thesis" = "Phong's model as the thesis writes it",
    "lambert" = "Lambert (1760): perfectly matte",
    "blinn-phong" = "Blinn (1977): the highlight by the half-way vector",
    "strauss" = "Strauss (1990): smooth, metallic, transparent",
    "strauss-thesis" = "Strauss's model as the thesis prints it",
    "lommel-seeliger" = "Lommel, Seeliger (1887): the dark, flat disc of the full Moon",
    "hapke" = "Hapke (1981, 2012): ground of grains, with the opposition effect",
    "retroreflection" = "Belcour and others (2014): signs and vests that send light back",
    "gooch" = "Gooch and others (1998): from warm to cool, as in technical drawings",
    "toon" = "cel shading (2000): a few even tones, a spot, a rim of light, ink",
    "marble" = "Perlin (1985): marble, its veins shaken by turbulence",
    "wood" = "Peachey (1985): rings around the axis of a trunk, and fibres",
    "physical-lights" = "lamps in watts and kelvin that fade with the square of the distance",
    "torrance-sparrow" = "Torrance and Sparrow (1967): facets in grooves, with highlights off the mirror direction",
    "cook-torrance" = "Cook and Torrance (1982): facets by Beckmann, Fresnel's law for metals and plastics",
    "ward" = "Ward (1992): gloss along and across a grain, as measured",
    "ggx" = "Walter and others (2007): rough dielectrics, with GGX, Beckmann's or Phong's facets",
    "ggx-anisotropic" = "Heitz (2014): metals with a grain, with masking that is correlated by height",
    "disney" = "Burley (2012): Disney's principled model",
    "disney-diffuse" = "Burley (2012): the diffuse part of Disney's model, beside Frostbite's and Lambert's",
    "openpbr" = "OpenPBR (2024): base and coat",
    "ashikhmin-shirley" = "Ashikhmin and Shirley (2000): Phong's lobe with a grain, over a matte base",
    "brushed-metal" = "brushed and turned metal: strokes of noise under a stretched highlight",
    "fresnel-glass" = "Fresnel (1823): glass and water, whose rays obey the law",
    "coloured-mirror" = "mirrors of metal, by Fresnel's law or Schlick's (1994)",
    "oren-nayar" = "Oren and Nayar (1994): rough matte surfaces, flat like the full Moon",
    "eon" = "Portsmouth, Kutz and Hill (2024): rough matte surfaces that lose no light",
    "minnaert" = "Minnaert (1941): discs of planets and moons, by their limb darkening",
    "schlick" = "Schlick (1994): from mirror over gloss to matte, in one layer or two, with a grain",
    "lafortune" = "Lafortune and others (1997): three lobes that fit measurements",
    "thin-film" = "Airy (1833): colours of soap bubbles, oil and anodised titanium",
    "lacquer" = "a matte colour under a smooth coat that absorbs: Fresnel, Beer, Saunderson (1942)",
    "kajiya-kay" = "Kajiya and Kay (1989): fur and hair by the direction of their fibres",
    "hair" = "Marschner and others (2003), Scheuermann (2004): hair with two highlights",
    "charlie-sheen" = "Estevez and Kulla (2017): the sheen of cloth",
    "velvet" = "Ashikhmin and others (2000, 2007): velvet, dark in the middle and bright at the edge",
    "leaf" = "Bousquet and others (2005): a leaf that light goes through",
);
const SCENES: &[Preset] = files!("scene", "scene":
    "studio" = "two balls under three lights, for a new formula",
    "shaderball" = "a shell with an opening, a core, a ring and a base, for one material",
    "showcase" = "the shader ball, a cut stone, mirrors and matte balls before a fan of colours",
    "daylight" = "the shader ball under a clear sky with the sun",
    "still-life" = "glass and ceramics between soft boxes, a lamp and a bulb",
    "glass" = "glass before a wall, and a mirror",
    "highlights" = "fifteen balls of plastic, copper and steel, to compare highlights",
    "sunset" = "water, silver, glass and a soap bubble at sunset",
    "crystals" = "balls of glass and mirrors before a fan of colours",
    "dozen" = "twelve coloured balls around a mirror",
    "phases" = "two rings of moons around a sun, from crescent to full",
    "regolith" = "boulders on an airless plain, the sun behind the viewer",
    "night-road" = "signs, posts and a walker in the light of a car",
    "bear" = "a toy bear between balls and a block, under one light",
    "pedestals" = "three balls on three blocks, for solid patterns",
    "room" = "a room with spotlights and lamps, in metres",
    "row" = "five balls side by side, to compare five values",
    "brushed" = "balls, a plate and sheets with a grain",
    "grazing" = "strips of a road towards low lamps",
    "shelves" = "two rows of four balls on shelves, to compare values and kinds",
    "planets" = "seven balls in space, the sun behind the viewer",
    "softboxes" = "nine balls on a dark table between bright panels",
    "heads" = "two rows of five balls on a shelf, for hair and cloth",
    "edges" = "three balls lit from both sides and from behind",
    "twig" = "nine leaves on a twig against the light",
);
const SESSIONS: &[Preset] = files!("session", "toml":
    "default" = "a shader ball of glass, with Phong's model: what opens if nothing is named",
    "shaderball" = "red lacquer and gold on the shader ball, by Fresnel's law",
    "shaderball-glass" = "the shader ball of glass, by Fresnel's law",
    "studio" = "two balls in a studio, with Phong's model",
    "glass" = "glass and a mirror, with Phong's model",
    "highlights" = "plastic, copper and steel, with Strauss's model",
    "sunset" = "water, silver and glass at sunset, with Phong's model",
    "crystals" = "glass and mirrors before a fan of colours, with Blinn's model",
    "dozen" = "twelve balls around a mirror, with Blinn's model",
    "daylight" = "the shader ball under a clear sky, with OpenPBR",
    "still-life" = "glass and glazed ceramics between soft boxes, by Fresnel's law",
    "lommel-seeliger" = "moons: flat by Lommel and Seeliger outside, round by Lambert inside",
    "hapke" = "an airless plain: the opposition effect on its right half",
    "retroreflection" = "a road at night: what sends the headlights back",
    "gooch" = "a toy bear drawn from warm to cool, in three pairs of colours",
    "toon" = "a toy bear in two to six tones",
    "marble" = "balls and blocks of seven marbles",
    "wood" = "balls and blocks of seven woods",
    "physical-lights" = "a room lit by bulbs of 1900 to 9500 kelvin",
    "torrance-sparrow" = "roads and metals in low light, with Torrance and Sparrow's model",
    "cook-torrance" = "plastic, copper and silver, rough to smooth, with Cook and Torrance's model",
    "ward" = "measured metals, wood and enamel, with Ward's model",
    "ggx" = "GGX, Beckmann's and Phong's facets, row by row",
    "ggx-anisotropic" = "gold with a grain from along to across, with anisotropic GGX",
    "disney" = "gold, plastic, and a row of special materials, with Disney's model",
    "disney-diffuse" = "matte balls from smooth to rough: Burley above, Frostbite below",
    "openpbr" = "clay, wood, car paint and metals, with OpenPBR",
    "ashikhmin-shirley" = "exponents along and across a grain, with Ashikhmin and Shirley's model",
    "brushed-metal" = "turned and brushed metals",
    "fresnel-glass" = "glass before a fan of colours, by Fresnel's law",
    "coloured-mirror" = "mirrors of gold, copper, silver and foil among coloured balls",
    "oren-nayar" = "plaster and clay, smooth to rough, with Oren and Nayar's model",
    "eon" = "rough matte balls that lose light, and below them those that do not",
    "minnaert" = "planets with bright, flat and dark edges",
    "schlick" = "gold from mirror to matte, and lacquers, with Schlick's model",
    "lafortune" = "measured paint, clay, skin and felt, and lobes that bend and turn back",
    "thin-film" = "soap bubbles before anodised titanium",
    "lacquer" = "amber varnish from none to thick, and red under coats",
    "kajiya-kay" = "a toy bear of fur, with Kajiya and Kay's model",
    "hair" = "five colours of hair, with two highlights",
    "charlie-sheen" = "sheen from thin to wide, and five cloths",
    "velvet" = "balls of velvet, lit along their edges",
    "leaf" = "leaves of spring and autumn against the sun",
);
const MATERIALS: &[Preset] = files!("material", "toml":
    "phong" = "materials for Phong's model",
    "blinn-phong" = "materials for Blinn's model",
    "strauss" = "materials for Strauss's model",
    "lommel-seeliger" = "grounds of moons and planets",
    "hapke" = "grounds of planets and asteroids, snow and sand",
    "retroreflection" = "sheets, cloth and eyes that send light back",
    "gooch" = "pairs of warm and cool colours",
    "toon" = "vinyl, cloth, fur and metal of cartoons",
    "marble" = "seven marbles",
    "wood" = "seven woods",
    "physical-lights" = "surfaces by their reflectance",
    "torrance-sparrow" = "materials for Torrance and Sparrow's model",
    "cook-torrance" = "materials for Cook and Torrance's model",
    "ward" = "measured materials for Ward's model",
    "ggx" = "materials for the GGX model",
    "ggx-anisotropic" = "metals with measured indices for anisotropic GGX",
    "disney" = "materials for Disney's principled model",
    "disney-diffuse" = "materials for Disney's diffuse model",
    "openpbr" = "materials for OpenPBR",
    "ashikhmin-shirley" = "materials for Ashikhmin and Shirley's model",
    "brushed-metal" = "brushed and turned metals with measured indices",
    "fresnel-glass" = "glass, water and gems",
    "coloured-mirror" = "mirrors of metal with measured indices, and of foil",
    "oren-nayar" = "plaster, sand, clay and cloth",
    "eon" = "chalk, clay, plaster and powder",
    "minnaert" = "planets and moons",
    "schlick" = "metals, lacquers and varnish",
    "lafortune" = "measured and made-up lobes",
    "thin-film" = "bubbles, oil, coated glass and anodised metals",
    "lacquer" = "varnish, urushi, glaze and wet stone",
    "kajiya-kay" = "fur, hair and threads",
    "hair" = "hair of eight kinds",
    "charlie-sheen" = "cloth with a sheen",
    "velvet" = "velvet and other cloth with a pile",
    "leaf" = "leaves, and paper",
);

/// A built-in mesh, which scenes name as `preset:NAME`.
#[derive(Debug)]
pub struct PresetMesh {
    /// Its name, without `preset:`.
    pub name: &'static str,
    /// What it is: one line.
    pub about: &'static str,
    /// The name of its file, whose suffix tells the format.
    pub file: &'static str,
    /// The contents of its file.
    pub bytes: &'static [u8],
}

macro_rules! meshes {
    ($($name:literal . $suffix:literal = $about:literal),* $(,)?) => {
        &[$(PresetMesh {
            name: $name,
            about: $about,
            file: concat!($name, ".", $suffix),
            bytes: include_bytes!(concat!("../../presets/mesh/", $name, ".", $suffix)),
        },)*]
    };
}

/// The built-in meshes.
pub const MESHES: &[PresetMesh] = meshes!(
    "gem"."obj" = "a round brilliant, its girdle of radius 1 around the y axis",
    "shaderball-ball"."ply" = "the shell of the shader ball, of radius 1, with a round opening",
    "shaderball-core"."ply" = "the ball inside the shell",
    "shaderball-ring"."ply" = "the fluted ring around the neck of the base",
    "shaderball-base"."ply" = "the base of the shader ball, which stands on y = 0",
    "backdrop"."ply" = "a floor that bends up to a wall behind the shader ball",
);

/// The built-in files of a kind, in the order of menus and lists.
pub fn all(kind: FileKind) -> &'static [Preset] {
    match kind {
        FileKind::Formula => FORMULAS,
        FileKind::Scene => SCENES,
        FileKind::Session => SESSIONS,
        FileKind::Material => MATERIALS,
    }
}

/// The text of a built-in file.
pub fn text(kind: FileKind, name: &str) -> Option<&'static str> {
    all(kind).iter().find(|preset| preset.name == name).map(|preset| preset.text)
}

/// The names of all built-in files of a kind.
pub fn names(kind: FileKind) -> impl Iterator<Item = &'static str> {
    all(kind).iter().map(|preset| preset.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formula::Formula;
    use crate::lang::source::Source;
    use crate::mesh::{MeshRepairs, Reading, read_bytes};
    use crate::scene::Scene;
    use crate::workspace::{Library, Session};
    use std::path::Path;

    fn sources(kind: FileKind) -> impl Iterator<Item = Source> {
        names(kind).map(move |name| Source::new(name, text(kind, name).unwrap()))
    }

    #[test]
    fn all_built_in_files_are_sound() {
        for source in sources(FileKind::Formula) {
            Formula::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        }
        for source in sources(FileKind::Scene) {
            Scene::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        }
        for source in sources(FileKind::Session) {
            Session::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
        }
        for source in sources(FileKind::Material) {
            let (library, warnings) = Library::parse(&source).unwrap_or_else(|errors| panic!("{}", errors.located(&source)));
            assert!(warnings.is_empty() && library.len() >= 4, "{}", source.name());
        }
        assert!(text(FileKind::Session, DEFAULT_SESSION).is_some());
    }

    #[test]
    fn all_built_in_meshes_are_sound() {
        for mesh in MESHES {
            let (_, repairs) = read_bytes(Path::new(mesh.file), mesh.bytes, &Reading::unwatched(1 << 30)).expect(mesh.name);
            assert_eq!(repairs, MeshRepairs::default(), "{}", mesh.name);
        }
    }
}
