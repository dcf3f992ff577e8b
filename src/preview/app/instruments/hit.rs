//! A point of the picture, for the instruments: its surface, and the directions of one light and of the viewer.

use crate::evaluate::inspect::{InspectedHit, InspectedLight};
use crate::instrument::direction::angles;
use crate::instrument::model::Place;
use crate::lang::variables::Variable;
use crate::scene::{BodyId, LightId};
use glam::{DMat3, DVec3, Vec3};

/// A point of the picture with one light.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::preview::app) struct InstrumentPlace {
    pub(in crate::preview::app) body: BodyId,
    pub(in crate::preview::app) light: LightId,
    pub(super) place: Place,
    /// The coordinates of the surface, `u` and `v`.
    pub(super) coordinates: [f64; 2],
    /// The polar angle from the normal and the azimuth from the tangent of the light, in degrees.
    pub(super) light_angles: [f64; 2],
    /// The same of the viewer.
    pub(super) view_angles: [f64; 2],
    /// Where it is, in a few words.
    pub(super) words: String,
    /// All its numbers.
    pub(super) details: String,
}

impl InstrumentPlace {
    /// The place of a hit in a pixel, lit by one of its lights.
    pub(in crate::preview::app) fn new(pixel: [u32; 2], hit: &InspectedHit, light: &InspectedLight) -> Self {
        let variables = &hit.variables;
        let wide = |vector: Vec3| vector.as_dvec3();
        let frame = DMat3::from_cols(wide(variables.tangent), wide(variables.bitangent), wide(variables.normal));
        let local = |direction: Vec3| angles((frame.transpose() * wide(direction)).as_vec3().to_array());
        let number = |value: f32| DVec3::splat(f64::from(value));
        // What depends on the directions of charts follows from them.
        let given = vec![
            (Variable::Point, wide(variables.point)),
            (Variable::GeometricNormal, wide(variables.geometric_normal)),
            (Variable::RelativeIndex, number(variables.relative_index)),
            (Variable::Distance, number(light.variables.distance)),
        ];
        let [x, y] = pixel;
        let [light_angles, view_angles] = [light.variables.light, variables.view].map(local);
        let details = format!(
            "light {:.1}° from the normal, azimuth {:.1}°\nviewer {:.1}° from the normal, azimuth {:.1}°\npoint {:.4}\nu {:.4}, v {:.4}",
            light_angles[0],
            light_angles[1],
            view_angles[0],
            view_angles[1],
            variables.point,
            variables.coordinates.x,
            variables.coordinates.y
        );
        let words = format!("at pixel ({x}, {y})");
        let (body, light) = (hit.body(), light.light);
        let coordinates = variables.coordinates.as_dvec2().to_array();
        Self { body, light, place: Place { frame, given }, coordinates, light_angles, view_angles, words, details }
    }
}
