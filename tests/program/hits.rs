//! What another program, such as a notebook, makes of the hits that `dump --stage hits` writes.

use crate::files::render;
use crate::{SCENE, folder, told, write};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

/// A folder of columns.
struct Dump {
    folder: PathBuf,
    index: Value,
}

impl Dump {
    fn read(folder: &Path) -> Self {
        let index = fs::read(folder.join("index.json")).expect("an index");
        Self { folder: folder.to_owned(), index: serde_json::from_slice(&index).expect("JSON") }
    }

    /// The numbers of a column, as the index describes it, and how many each row has.
    fn column(&self, table: &str, name: &str) -> (Vec<[u8; 4]>, usize) {
        let table = &self.index["tables"][table];
        let columns = table["columns"].as_array().expect("columns");
        let column = columns.iter().find(|column| column["name"] == name).expect(name);
        let bytes = fs::read(self.folder.join(column["file"].as_str().expect("a file"))).expect("a column");
        let components = column["components"].as_u64().expect("a number") as usize;
        assert_eq!(bytes.len(), 4 * components * table["count"].as_u64().expect("a count") as usize, "{column}");
        (bytes.chunks_exact(4).map(|four| [four[0], four[1], four[2], four[3]]).collect(), components)
    }

    fn whole(&self, table: &str, name: &str) -> Vec<usize> {
        self.column(table, name).0.into_iter().map(|bytes| u32::from_le_bytes(bytes) as usize).collect()
    }

    fn scalars(&self, table: &str, name: &str) -> Vec<f64> {
        self.column(table, name).0.into_iter().map(|bytes| f32::from_le_bytes(bytes).into()).collect()
    }

    fn vectors(&self, table: &str, name: &str) -> Vec<[f64; 3]> {
        let (numbers, components) = self.column(table, name);
        assert_eq!(components, 3);
        numbers.chunks_exact(3).map(|three| [0, 1, 2].map(|at| f32::from_le_bytes(three[at]).into())).collect()
    }

    fn names(&self, list: &str) -> Vec<&str> {
        self.index[list].as_array().expect("a list").iter().map(|name| name.as_str().expect("a name")).collect()
    }
}

/// The values of the test, of the ball and of the floor.
const BODY_COLOUR: [[f64; 3]; 2] = [[0.9, 0.3, 0.2], [0.6, 0.7, 0.8]];
const REFLECTED: [f64; 2] = [0.25, 0.5];
const REFRACTED: f64 = 0.125;
/// A point, a spot that sends less at its edge, a sphere with many points, and an environment.
const LIGHTS: &str = "lights;
key: point, <4,6,5>;
cone: spot, <-3,4,3>, target <0,0,0>, angle 20, soft 15;
globe: sphere, center <-4,3,1>, radius 1;
sky: environment, \"preset:sky\", rotate 40;
camera;";
const LIGHT_COLOUR: [f64; 3] = [1.0, 0.9, 0.75];
const INTENSITY: [f64; 4] = [0.4, 0.7, 0.3, 0.5];
const AMBIENT: f64 = 0.05;
const BACKGROUND: [f64; 3] = [0.1, 0.2, 0.4];

/// The colours of all pixels by equation (2) with Lambert's formula, `IL*Cd*max(0, N.L)`.
fn lambert(dump: &Dump) -> Vec<[f64; 3]> {
    let [width, height] = ["width", "height"].map(|side| dump.index[side].as_u64().expect("a side") as usize);
    let none = dump.index["none"].as_u64().expect("a number") as usize;
    let (parents, edges, hit_bodies) = (dump.whole("paths", "parent"), dump.whole("paths", "edge"), dump.whole("paths", "body"));
    let edge_names = dump.names("edges");
    // Paths come after those that they continue.
    let mut weights: Vec<f64> = Vec::new();
    for (parent, edge) in parents.into_iter().zip(edges) {
        weights.push(match edge_names[edge] {
            "primary" => 1.0,
            "reflected" => weights[parent] * REFLECTED[hit_bodies[parent]],
            other => {
                assert_eq!(other, "refracted");
                weights[parent] * REFRACTED
            }
        });
    }
    let mut pixels = vec![[0.0; 3]; width * height];
    let share = dump.index["passes"]["weight"].as_f64().expect("a weight");
    let mut add = |pixel: usize, path: usize, colour: [f64; 3]| {
        (0..3).for_each(|component| pixels[pixel][component] += share * weights[path] * colour[component]);
    };
    let (at, paths, bodies) = (dump.whole("hits", "pixel"), dump.whole("hits", "path"), dump.whole("hits", "body"));
    let normals = dump.vectors("hits", "N");
    for hit in 0..at.len() {
        add(at[hit], paths[hit], BODY_COLOUR[bodies[hit]].map(|colour| AMBIENT * colour));
    }
    let (hits, to_light) = (dump.whole("records", "hit"), dump.vectors("records", "L"));
    let (radiance, weight) = (dump.vectors("records", "radiance"), dump.scalars("records", "weight"));
    let lights = dump.whole("records", "light");
    for (record, hit) in hits.into_iter().enumerate() {
        let cosine: f64 = (0..3).map(|axis| normals[hit][axis] * to_light[record][axis]).sum();
        let local = |component: usize| {
            LIGHT_COLOUR[component] * radiance[record][component] * BODY_COLOUR[bodies[hit]][component] * cosine.max(0.0)
        };
        add(at[hit], paths[hit], [0, 1, 2].map(|component| INTENSITY[lights[record]] * weight[record] * local(component)));
    }
    let sky = dump.index["environment"].as_u64().expect("a light") as usize;
    let (at, seen) = (dump.whole("misses", "pixel"), dump.vectors("misses", "radiance"));
    for (miss, path) in dump.whole("misses", "path").into_iter().enumerate() {
        assert_eq!(hit_bodies[path], none);
        let colour = |component: usize| BACKGROUND[component] + INTENSITY[sky] * LIGHT_COLOUR[component] * seen[miss][component];
        add(at[miss], path, [0, 1, 2].map(colour));
    }
    pixels
}

#[test]
fn a_picture_of_several_passes_is_computed_again_from_its_hits() {
    let folder = folder();
    write(&folder, "lambert.formula", "formula; = IL*Cd*max(0, N.L);");
    let point = "lights;\nkey: point, <4,6,5>;\ncamera;";
    assert!(SCENE.contains(point));
    write(&folder, "sub/lights.scene", &SCENE.replace(point, LIGHTS));
    let vector = |[x, y, z]: [f64; 3]| format!("<{x},{y},{z}>");
    let [ball, floor] = BODY_COLOUR.map(vector);
    let options = format!(
        "-f lambert.formula -s sub/lights.scene --size 32x24 --depth 3 --samples 4 --background {} --set ka={AMBIENT} \
         --set ball.Cd={ball} --set floor.Cd={floor} --set ball.kr={} --set floor.kr={} --set ball.kt={REFRACTED} \
         --set *.IL={} --set key.ki={} --set cone.ki={} --set globe.ki={} --set sky.ki={}",
        vector(BACKGROUND),
        REFLECTED[0],
        REFLECTED[1],
        vector(LIGHT_COLOUR),
        INTENSITY[0],
        INTENSITY[1],
        INTENSITY[2],
        INTENSITY[3],
    );
    assert_eq!(told(folder.path(), &format!("dump {options} --stage hits -o hits")), "exit status 0\n");
    let dump = Dump::read(&folder.path().join("hits"));
    assert_eq!((dump.names("bodies"), dump.names("lights")), (vec!["ball", "floor"], vec!["key", "cone", "globe", "sky"]));
    assert_eq!(dump.index["passes"], serde_json::json!({ "count": 4, "weight": 0.25 }));
    let radiance = dump.vectors("records", "radiance");
    assert!(radiance.iter().any(|[red, ..]| (0.1..0.9).contains(red)) && radiance.contains(&[1.0; 3]));
    let picture = render(folder.path(), &options, "out.exr").into_rgb32f();
    let one = render(folder.path(), &format!("{options} --samples 1").replace("--samples 4 ", ""), "one.exr").into_rgb32f();
    let mut far = 0;
    for (pixel, computed) in lambert(&dump).into_iter().enumerate() {
        let place = (pixel as u32 % 32, pixel as u32 / 32);
        let (drawn, first) = (picture.get_pixel(place.0, place.1).0, one.get_pixel(place.0, place.1).0);
        for component in 0..3 {
            let error = (computed[component] - f64::from(drawn[component])).abs();
            assert!(error < 1e-5 * computed[component].max(1.0), "{place:?}: computed {computed:?}, drawn {drawn:?}");
        }
        far += usize::from((computed[0] - f64::from(first[0])).abs() > 1e-2);
    }
    assert!(far > 20, "{far} pixels differ from those of one pass");
    // Rays of the first pass that leave the scene go through the middle of their pixels, as the camera looks.
    let directions = dump.vectors("misses", "direction");
    let corner = (0..directions.len()).find(|miss| dump.whole("misses", "pixel")[*miss] == 0).expect("the sky in the corner");
    let half = 20.0_f64.to_radians().tan();
    let [ahead, up] = [[0.0, -0.15, -1.0], [0.0, 1.0, -0.15]].map(|[x, y, z]: [f64; 3]| {
        let length = (x * x + y * y + z * z).sqrt();
        [x, y, z].map(|component| component / length)
    });
    let (across, high) = (-31.0 / 24.0 * half, 23.0 / 24.0 * half);
    let way = [ahead[0] + across, ahead[1] + high * up[1], ahead[2] + high * up[2]];
    let length = way.iter().map(|component| component * component).sum::<f64>().sqrt();
    for axis in 0..3 {
        assert!((directions[corner][axis] - way[axis] / length).abs() < 1e-6, "{:?} {way:?}", directions[corner]);
    }
    // The pixels of each pass have primary rays of their own: a hit or a miss each.
    let [hits, misses] = ["hits", "misses"].map(|table| {
        let (pixels, passes, paths) = (dump.whole(table, "pixel"), dump.whole(table, "pass"), dump.whole(table, "path"));
        let none = u64::from(u32::MAX) as usize;
        let parents = dump.whole("paths", "parent");
        let primary = (0..pixels.len()).filter(move |row| parents[paths[*row]] == none);
        primary.map(|row| (passes[row], pixels[row])).collect::<Vec<_>>()
    });
    let mut primary = [hits, misses].concat();
    primary.sort_unstable();
    let all: Vec<_> = (0..4).flat_map(|pass| (0..32 * 24).map(move |pixel| (pass, pixel))).collect();
    assert_eq!(primary, all);
}

#[test]
fn the_hits_of_one_pass_are_those_of_the_first_of_several() {
    let folder = folder();
    let dump = |options: &str| {
        assert_eq!(told(folder.path(), &format!("dump session.toml {options} --stage hits -o hits")), "exit status 0\n");
        let dump = Dump::read(&folder.path().join("hits"));
        let first = dump.whole("hits", "pass").iter().take_while(|pass| **pass == 0).count();
        (dump.vectors("hits", "point"), first, dump.index["passes"]["count"].as_u64())
    };
    let (one, count, passes) = dump("");
    assert_eq!((count, passes), (one.len(), Some(1)));
    let (two, first, passes) = dump("--samples 2");
    assert_eq!((first, passes), (count, Some(2)));
    assert_eq!(two[..first], one);
    assert!(two.len() > first && two[first..] != one[..]);
}
