//! A scene as text of the scene language, in one canonical form: one declaration a line, every number in the shortest
//! form that reads back exactly.

use crate::scene::values::{SceneNumber, Vector};
use crate::scene::{Camera, Light, MeshShading, Scene};
use std::fmt::{Display, Formatter, Result};

impl Display for Scene {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "bodies;")?;
        for body in &self.bodies {
            write!(f, "{}: {}", body.name, body.form)?;
            if let Some(index) = body.refractive_index {
                write!(f, ", refractive_index {}", SceneNumber(index))?;
            }
            let (flat, smooth) = (Some(MeshShading::Flat), Some(MeshShading::Smooth));
            let attributes = [
                (body.shading == flat, "flat"),
                (body.shading == smooth, "smooth"),
                (body.opaque, "opaque"),
                (body.matte, "matte"),
            ];
            for (_, word) in attributes.into_iter().filter(|(set, _)| *set) {
                write!(f, ", {word}")?;
            }
            writeln!(f, ";")?;
        }
        writeln!(f, "lights;")?;
        for Light { name, kind, .. } in &self.lights {
            writeln!(f, "{name}: {kind};")?;
        }
        write!(f, "{}", self.camera)
    }
}

impl Display for Camera {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "camera;\nposition {};\ngaze {};", Vector(self.position()), Vector(self.gaze()))?;
        writeln!(f, "up {};\nfov {};", Vector(self.up()), SceneNumber(self.fov()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::source::Source;
    use glam::DVec3;
    use proptest::prelude::*;

    /// Numbers of any size that a scene may hold.
    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![
            (-1e30..1e30f64),
            (-10.0..10.0f64),
            (-300i32..300).prop_map(|tenths| f64::from(tenths) / 10.0),
            (-1.0..1.0f64, -30..30i32).prop_map(|(digits, exponent)| digits * 10f64.powi(exponent)),
        ]
    }

    fn positive() -> impl Strategy<Value = f64> {
        number().prop_map(|number| number.abs().max(1e-30))
    }

    fn vector() -> impl Strategy<Value = DVec3> {
        (number(), number(), number()).prop_map(DVec3::from)
    }

    fn body(name: usize) -> impl Strategy<Value = String> {
        let shape = prop_oneof![
            (vector(), positive()).prop_map(|(center, radius)| format!(
                "sphere, center {}, radius {}",
                Vector(center),
                SceneNumber(radius)
            )),
            (-10.0..10.0f64, 0.1..10.0f64).prop_map(|(x, width)| {
                let corner = |x, y| Vector(DVec3::new(x, y, 0.0));
                format!("rectangle, {}, {}, {}", corner(x, 0.0), corner(x, 1.5), corner(x + width, 1.5))
            }),
            (vector(), positive()).prop_map(|(center, radius)| format!(
                "disc, center {}, normal <0, 0.5, 2>, radius {}",
                Vector(center),
                SceneNumber(radius)
            )),
            (-10.0..10.0f64, 0.1..10.0f64, positive(), 0..4).prop_map(|(x, height, radius, kind)| {
                let [base, top] = [DVec3::new(x, 0.25, 1.0), DVec3::new(x + 2.0, height + 0.5, -3.0)].map(Vector);
                match kind {
                    0 => format!("box, {base}, {top}"),
                    1 => format!("triangle, {base}, <0, 9, 100>, {top}"),
                    2 => format!("cylinder, {base}, {top}, radius {}", SceneNumber(radius)),
                    _ => format!("cone, {base}, {top}, radius {}", SceneNumber(radius)),
                }
            }),
        ];
        let factor = || prop_oneof![(-10.0..-0.1f64), (0.1..10.0f64)];
        let place = || (-1e3..1e3f64, -1e3..1e3f64, -1e3..1e3f64).prop_map(|place| Vector(DVec3::from(place)).to_string());
        let transform = prop_oneof![
            factor().prop_map(|factor| format!(", scale {}", SceneNumber(factor))),
            (factor(), factor(), factor()).prop_map(|factors| format!(", scale {}", Vector(factors.into()))),
            (place(), number()).prop_map(|(axis, angle)| format!(", rotate {axis} {}", SceneNumber(angle))),
            place().prop_map(|by| format!(", translate {by}")),
            (place(), positive()).prop_map(|(center, size)| format!(", fit {center} {}", SceneNumber(size))),
        ];
        let transforms = proptest::collection::vec(transform, 0..4);
        let body = (shape, transforms, proptest::option::of(positive()), any::<bool>(), any::<bool>());
        body.prop_map(move |(shape, transforms, index, opaque, matte)| {
            let index = index.map_or(String::new(), |index| format!(", refractive_index {}", SceneNumber(index)));
            let words = [if opaque { ", opaque" } else { "" }, if matte { ", matte" } else { "" }].concat();
            format!("b{name}: {shape}{}{index}{words};\n", transforms.concat())
        })
    }

    /// A light as the scene language writes it, without its name.
    fn light() -> impl Strategy<Value = String> {
        let angles = (0.001..=180.0f64, proptest::option::of(0.0..=1.0f64)).prop_map(|(angle, share)| {
            let soft = share.map_or(String::new(), |share| format!(", soft {}", SceneNumber(share * angle)));
            format!("angle {}{soft}", SceneNumber(angle))
        });
        prop_oneof![
            vector().prop_map(|position| format!("point, {}", Vector(position))),
            (vector(), positive()).prop_map(|(direction, z)| format!("directional, {}", Vector(direction.with_z(z)))),
            (vector(), positive(), angles).prop_map(|(position, x, angles)| {
                format!("spot, {}, target {}, {angles}", Vector(position.with_x(-x)), Vector(position.with_x(x)))
            }),
            (vector(), positive()).prop_map(|(center, radius)| format!(
                "sphere, center {}, radius {}",
                Vector(center),
                SceneNumber(radius)
            )),
            (-10.0..10.0f64, 0.1..10.0f64).prop_map(|(z, width)| {
                let [a, b, c] = [(0.0, 0.0), (0.0, -0.5), (width, -0.5)].map(|(x, y)| Vector(DVec3::new(x, y, z)));
                format!("rectangle, {a}, {b}, {c}")
            }),
        ]
    }

    proptest! {
        #[test]
        fn a_printed_scene_reads_back_unchanged(
            bodies in (body(0), body(1), body(2)),
            lights in proptest::collection::vec(light(), 0..4),
            position in vector(),
            fov in 0.001..179.999f64,
        ) {
            let mut text = format!("bodies;\n{}{}{}lights;\n", bodies.0, bodies.1, bodies.2);
            for (number, light) in lights.iter().enumerate() {
                text.push_str(&format!("l{number}: {light};\n"));
            }
            text.push_str(&format!("camera;\nposition {};\ngaze <0.3, 1, -2>;\nup <0, 1, 0>;\nfov {};\n", Vector(position), fov));
            let scene = Scene::parse(&Source::new("t", text.clone())).unwrap().0;
            prop_assert_eq!(&scene.to_string(), &text);
            // The text is canonical, so even the places of the names agree.
            prop_assert_eq!(Scene::parse(&Source::new("t", scene.to_string())).unwrap().0, scene);
        }
    }
}
