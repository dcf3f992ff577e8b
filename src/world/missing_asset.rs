//! Why there is no world of a scene: it names something that was not given.

/// A scene names something that was not given.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MissingAsset {
    /// The mesh of a body.
    #[error("the mesh \"{path}\" of the body `{body}` was not read")]
    Mesh {
        /// The name of the body.
        body: String,
        /// The name of the mesh.
        path: String,
    },
    /// The image of an environment.
    #[error("the image \"{path}\" of the light `{light}` was not read")]
    Map {
        /// The name of the light.
        light: String,
        /// The name of the image.
        path: String,
    },
}
