//! Words that other programs use in scenes, with ours, and the order of parts.

/// The shape that a word means elsewhere.
pub(super) fn shape(word: &str) -> Option<&'static str> {
    Some(match word.to_lowercase().as_str() {
        "ellipsoid" | "spheroid" | "egg" | "ellipse" => {
            "such a body is a `sphere` with a scale: `sphere, center <0, 0, 0>, radius 1, scale <1, 2, 1>`"
        }
        "ball" | "globe" | "orb" | "spheres" | "uvsphere" => "a ball is a `sphere`",
        "plane" | "quad" | "square" | "rect" | "wall" | "floor" | "ground" | "polygon" | "parallelogram" | "grid" => {
            "a piece of a plane is a `rectangle`; a floor is a large one"
        }
        "cube" | "cuboid" | "parallelepiped" | "boxes" | "block" | "brick" | "aabb" => "such a body is a `box`",
        "disk" | "circle" | "discs" => "a flat round piece is a `disc`",
        "tube" | "pipe" | "rod" | "capsule" | "cylinders" => "such a body is a `cylinder`, closed at both ends",
        "pyramid" | "cones" => "a round body with a point is a `cone`",
        "meshes" | "obj" | "ply" | "stl" | "gltf" | "glb" | "triangles" | "trianglemesh" | "model" | "file" | "import"
        | "load" => "triangles from a file are a `mesh`",
        _ => return None,
    })
}

/// The kind of light that a word means elsewhere.
pub(super) fn light(word: &str) -> Option<&'static str> {
    Some(match word.to_lowercase().as_str() {
        "sun" | "sunlight" | "parallel" | "distant" | "infinite" | "directionallight" | "directional_light" | "direction" => {
            "parallel light is `directional`, with the direction in which it travels"
        }
        "spotlight" | "spot_light" | "conelight" | "projector" | "flashlight" => "such a light is a `spot`",
        "area" | "arealight" | "area_light" | "rect" | "rectlight" | "quad" | "square" | "plane" | "panel" | "softbox"
        | "disk" | "tube" => "lights that are spread over an area are a `rectangle` or a `sphere`",
        "ball" | "spherelight" | "sphere_light" | "spherical" | "globe" => "such a light is a `sphere`",
        "ambient" => "ambient light is no light of the scene: its values are `ka` and `Ia`",
        "dome" | "sky" | "hdri" | "hdr" | "envmap" | "skylight" | "skybox" | "ibl" | "domelight" | "environmentmap" => {
            "light from all around is an `environment`"
        }
        "pointlight" | "omni" | "bulb" | "lamp" | "light" | "point_light" => "such a light is a `point`",
        _ => return None,
    })
}

/// The section that a word heads elsewhere.
pub(super) fn section(word: &str) -> Option<&'static str> {
    Some(match word.to_lowercase().as_str() {
        "body" | "objects" | "object" | "shapes" | "shape" | "geometry" | "surfaces" | "primitives" | "models" => "bodies",
        "light" | "lamps" | "lamp" | "lighting" | "sources" | "emitters" => "lights",
        "cam" | "view" | "viewer" | "eye" | "observer" | "cameras" => "camera",
        _ => return None,
    })
}

/// What to say about a place that is looked at.
pub(super) const TARGET: &str = "`gaze` is a direction: the place that is looked at minus the position";

/// The clause of the camera that a word means elsewhere, with a remark on what differs.
pub(super) fn camera_clause(word: &str) -> Option<(&'static str, &'static str)> {
    let plain: String = word.chars().filter(|letter| *letter != '_').collect::<String>().to_lowercase();
    Some(match plain.as_str() {
        "lookat" | "target" | "at" | "to" | "focus" | "center" | "centre" | "interest" | "poi" | "look" | "aim" => {
            ("gaze", TARGET)
        }
        "direction" | "dir" | "forward" | "front" | "view" | "viewdir" | "lookdir" | "axis" | "gazedirection" => {
            ("gaze", "the direction is written `gaze <x, y, z>`")
        }
        "eye" | "from" | "location" | "pos" | "origin" | "eyepoint" | "place" | "point" | "translation" | "lookfrom" => {
            ("position", "the place is written `position <x, y, z>`")
        }
        "sky" | "vup" | "upvector" | "upward" | "viewup" | "updirection" | "top" => {
            ("up", "the direction up is written `up <x, y, z>`")
        }
        "angle" | "fovy" | "fieldofview" | "fovx" | "yfov" | "viewangle" | "zoom" | "focallength" | "lens" | "hfov" | "vfov" => {
            ("fov", "the angle is written `fov DEGREES`: from the lower to the upper edge")
        }
        _ => return None,
    })
}

/// What a word behind a body or a light means elsewhere, that a scene does not have.
pub(super) fn property(word: &str) -> Option<&'static str> {
    Some(match word.to_lowercase().as_str() {
        "color" | "colour" | "rgb" | "diffuse" | "albedo" | "kr" | "kt" | "kd" | "ks" | "cd" | "material" | "shader"
        | "specular" | "reflectivity" | "roughness" | "texture" | "emission" | "alpha" | "brdf" => {
            "colours and other values of bodies belong in a session, or are given by `--set BODY.Cd=<1, 0, 0>`"
        }
        "ior" | "index" | "refraction" | "refractive" | "refractiveindex" | "n" => {
            "the refractive index is written `refractive_index 1.5`"
        }
        "diffuse_only" | "no_reflection" | "noreflect" => "a body that never reflects is `matte`",
        "solid" | "no_refraction" | "norefract" => "a body that never refracts is `opaque`",
        "translation" | "move" | "offset" | "shift" | "displace" | "position" | "location" | "at" => {
            "a body is moved by `translate <x, y, z>`"
        }
        "rotation" | "turn" | "orient" | "orientation" | "rotate_x" | "rotate_y" | "rotate_z" | "rotatex" | "rotatey"
        | "rotatez" | "euler" | "quaternion" => "a body is turned about an axis by `rotate <0, 1, 0> DEGREES`",
        "scaling" | "size" | "resize" | "stretch" | "zoom" | "enlarge" | "mirror" | "flip" => {
            "a body is resized by `scale NUMBER`, stretched by `scale <x, y, z>`, and mirrored by a scale below 0"
        }
        "normalize" | "normalise" | "center_at" | "fit_to" | "bounds" | "bbox" => {
            "a body gets a place and a size by `fit <x, y, z> SIZE`"
        }
        "transform" | "matrix" | "transformation" | "tomatrix" => {
            "transforms are `scale`, `rotate`, `translate` and `fit`, and are applied in the order written"
        }
        _ => return None,
    })
}

/// What a word behind a light means elsewhere, that a scene does not have.
pub(super) fn light_property(word: &str) -> Option<&'static str> {
    Some(match word.to_lowercase().as_str() {
        "color" | "colour" | "rgb" | "intensity" | "power" | "energy" | "ki" | "il" | "strength" | "brightness" | "exponent"
        | "flux" | "lumen" | "watt" | "candela" => {
            "colour and intensity are values of a session, or are given by `--set LIGHT.IL=<1, 1, 0.8>` and `--set LIGHT.ki=0.5`"
        }
        "radius" | "size" | "width" | "height" => "a light with a size is a `sphere` or a `rectangle`",
        "falloff" | "decay" | "attenuation" | "range" | "distance" => {
            "how light gets weaker with the distance is up to the formula, as in `IL/dist^2`"
        }
        "cutoff" | "cone" | "target" | "angle" | "soft" | "outer" => {
            "a light that shines within a cone is a `spot`: `spot, <3, 5, 4>, target <0, 1, 0>, angle 25, soft 5`"
        }
        "softness" | "penumbra" | "blend" | "inner" | "smooth" | "edge" | "feather" => {
            "a spot has a soft edge by `soft DEGREES`, and shadows are soft under a `sphere` or a `rectangle`"
        }
        "direction" | "dir" | "gaze" | "normal" => {
            "light in one direction is `directional`, and a `spot` has a target in its direction"
        }
        "shadow" | "shadows" | "castshadow" | "cast_shadows" | "noshadow" | "shadowless" => {
            "shadow rays are sent for all lights or for none, as a session says"
        }
        "samples" | "subdivisions" | "rays" => "how many points of a light are drawn is the number of passes: `--samples`",
        _ => return None,
    })
}

/// What a word in the place of a word of spot lights means elsewhere.
pub(super) fn spot_clause(found: &str, expected: &str) -> Option<&'static str> {
    let plain: String = found.chars().filter(|letter| *letter != '_').collect::<String>().to_lowercase();
    Some(match (plain.as_str(), expected) {
        ("direction" | "dir" | "gaze" | "axis" | "normal", "target") => {
            "the target is a place: the position of the light plus the direction"
        }
        ("lookat" | "pointat" | "at" | "to" | "aim" | "center" | "centre" | "focus" | "interest", "target") => {
            "the place to which the light shines is written `target <x, y, z>`"
        }
        (
            "cutoff" | "cone" | "coneangle" | "outer" | "outerangle" | "outercone" | "outerconeangle" | "halfangle" | "degrees"
            | "radius" | "fov" | "width" | "spread" | "size" | "beam" | "beamangle" | "spotsize",
            "angle",
        ) => "the angle between the middle of the cone and its edge is written `angle DEGREES`",
        _ => return None,
    })
}
