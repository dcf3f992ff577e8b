// Equation (2) for a pixel: the values of its rays. A ray comes after the rays that go on from it.

struct FrameNumbers {
    at_misses: vec3<f32>,
    // 0. No compiler knows.
    zero: u32,
    // What the radiance of the environment is multiplied by.
    environment: vec3<f32>,
    sees_environment: u32,
    lights: u32,
    // Where numbers begin: whether each pair of a body and a light is active, what is added at each hit on a body, kr
    // and kt of each body, and the uniform values of bodies. Those of pairs come first.
    active_pairs: u32,
    at_hits: u32,
    weights: u32,
    bodies: u32,
}

@group(0) @binding(0) var<uniform> frame: FrameNumbers;
@group(0) @binding(1) var<storage, read> numbers: array<f32>;
@group(0) @binding(2) var<storage, read> texels: array<f32>;
// For each number of a texture: where its texels begin, its width and its height.
@group(0) @binding(3) var<storage, read> textures: array<vec4<u32>>;

// Static values, as the compiled backend stores them: lines of sixteen numbers.
@group(1) @binding(0) var<storage, read> columns: array<f32>;
@group(1) @binding(1) var<storage, read> hit_columns: array<f32>;
// For each line of hits: where its columns of hits begin, those of records for the first light, how far it is from one
// light to the next, and where the list of lights is.
@group(1) @binding(2) var<storage, read> lines: array<vec4<u32>>;
// Lists of lights, and of the places of hits in several groups. Each begins with its length.
@group(1) @binding(3) var<storage, read> lists: array<u32>;
// For each pixel: its first hit, its first miss, and the set of its rays.
@group(1) @binding(4) var<storage, read> pixels: array<u32>;
// For each set, where its rays begin and end. Then the rays: the body or NONE; and how many rays come before it, how it
// came to be, which rays go on, and its number among the hits or misses of the pixel.
@group(1) @binding(5) var<storage, read> sets: array<vec2<u32>>;
// Where each hit is among the lines.
@group(1) @binding(6) var<storage, read> places: array<u32>;
// The same among the lines of `hit_columns`.
@group(1) @binding(7) var<storage, read> nodes: array<u32>;
// What misses see of the environment.
@group(1) @binding(8) var<storage, read> radiance: array<f32>;

@group(2) @binding(0) var<storage, read_write> picture: array<f32>;
// Whether the pixels are added to those of the passes before.
@group(2) @binding(1) var<uniform> adds: vec4<u32>;

const NONE: u32 = 0xffffffffu;
const SEVERAL: u32 = 0x80000000u;

// A weighted number: 0 if the weight is.
fn weighed(weight: f32, number: f32) -> f32 {
    return select(strict(weight * number), 0.0, weight == 0.0);
}

// A colour weighted by components: 0 if the weight is 0 in all of them.
fn weighed_by(weight: vec3<f32>, colour: vec3<f32>) -> vec3<f32> {
    let product = vec3<f32>(strict(weight.x * colour.x), strict(weight.y * colour.y), strict(weight.z * colour.z));
    return select(product, vec3<f32>(0.0), weight.x == 0.0 && weight.y == 0.0 && weight.z == 0.0);
}

fn colour_at(first: u32) -> vec3<f32> { return vec3<f32>(numbers[first], numbers[first + 1u], numbers[first + 2u]); }

// The light of a hit that is in this place among the lines, added to what is known.
fn lit_at(body: u32, place: u32, before: vec3<f32>) -> vec3<f32> {
    var sum = before;
    let line = lines[place >> 4u];
    let lane = place & 15u;
@HIT_COLUMNS@
    let count = lists[line.w];
    for (var at = 0u; at < count; at++) {
        let pair = body * frame.lights + lists[line.w + 1u + at];
        if (numbers[frame.active_pairs + pair] == 0.0) { continue; }
        let record = (line.y + at * line.z) * 16u + lane;
        let uniforms = pair * @UNIFORMS@u;
@CONTRIBUTION@
        sum += @RESULT@;
    }
    return sum;
}

fn lit(body: u32, place: u32) -> vec3<f32> {
    var sum = vec3<f32>(0.0);
    if (place == NONE) { return sum; }
    if ((place & SEVERAL) == 0u) { return lit_at(body, place, sum); }
    let list = place & ~SEVERAL;
    let count = lists[list];
    for (var at = 0u; at < count; at++) { sum = lit_at(body, lists[list + 1u + at], sum); }
    return sum;
}

// What a formula gives at a hit: its own light, and the weights of the rays that go on.
struct Given { own: vec3<f32>, reflected: vec3<f32>, refracted: vec3<f32> }

fn given(body: u32, hit: u32) -> Given {
    var result: Given;
@GIVEN@
    return result;
}

// E of a hit, whose rays that go on have these values.
fn at_hit(body: u32, hit: u32, goes_on: u32, reflected: vec3<f32>, refracted: vec3<f32>) -> vec3<f32> {
    let own = given(body, hit);
    var sum = lit(body, places[hit]) + colour_at(frame.at_hits + 3u * body) + own.own;
    let weights = frame.weights + 2u * body;
    if ((goes_on & 1u) != 0u) { sum += @REFLECTED@; }
    if ((goes_on & 2u) != 0u) { sum += @REFRACTED@; }
    return sum;
}

fn at_miss(miss: u32) -> vec3<f32> {
    if (frame.sees_environment == 0u) { return frame.at_misses; }
    let first = 3u * miss;
    let x = strict(frame.environment.x * radiance[first]);
    let y = strict(frame.environment.y * radiance[first + 1u]);
    let z = strict(frame.environment.z * radiance[first + 2u]);
    return frame.at_misses + vec3<f32>(x, y, z);
}

@compute @workgroup_size(64)
fn add_up(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = 3u * id.x;
    // A buffer may have room for more than the pixels, but not for a whole one.
    if (pixel + 2u >= arrayLength(&pixels)) { return; }
    let own = sets[pixels[pixel + 2u]];
    var colour = vec3<f32>(0.0);
    // The values of the last rays at each depth.
    var reflected: array<vec3<f32>, @LEVELS@>;
    var refracted: array<vec3<f32>, @LEVELS@>;
    for (var at = own.x; at < own.y; at++) {
        let ray = sets[at];
        let level = ray.y & 15u;
        let edge = (ray.y >> 4u) & 3u;
        let number = ray.y >> 8u;
        var value: vec3<f32>;
        if (ray.x == NONE) {
            value = at_miss(pixels[pixel + 1u] + number);
        } else {
            value = at_hit(ray.x, pixels[pixel] + number, (ray.y >> 6u) & 3u, reflected[level + 1u], refracted[level + 1u]);
        }
        if (edge == 0u) { colour = value; } else if (edge == 1u) { reflected[level] = value; } else { refracted[level] = value; }
    }
    if (adds.x != 0u) { colour += colour_of(pixel); }
    picture[pixel] = colour.x;
    picture[pixel + 1u] = colour.y;
    picture[pixel + 2u] = colour.z;
}

fn colour_of(pixel: u32) -> vec3<f32> { return vec3<f32>(picture[pixel], picture[pixel + 1u], picture[pixel + 2u]); }
