//! Images of environments.

use super::*;
use glam::DVec3;
use image::{Rgb, Rgb32FImage, RgbImage, Rgba, Rgba32FImage};

/// A scene with a light.
fn lit(light: &str) -> (Scene, Source) {
    let camera = "camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 45;";
    let source = Source::new("test.scene", format!("bodies; lights;\nsky: {light};\n{camera}"));
    (Scene::parse(&source).unwrap().0, source)
}

/// What is said about the environment of a scene in a folder.
fn said_of(light: &str, folder: &Path) -> String {
    let (scene, source) = lit(light);
    let place = Location::File(folder.join("test.scene"));
    let found = match AssetStore::default().load(&scene, &place, &Reading::unwatched(1 << 30)) {
        Ok((_, warnings)) => warnings,
        Err(AssetLoadError::Unusable(errors)) => errors,
        Err(AssetLoadError::Cancelled) => panic!("cancelled"),
    };
    format!("{:#}", found.located(&source)).replace(&folder.display().to_string(), "FOLDER")
}

/// An image of 16×8 texels, red towards +x and green elsewhere.
fn image() -> Rgb32FImage {
    Rgb32FImage::from_fn(16, 8, |x, _| if x < 8 { Rgb([4.0, 0.0, 0.0]) } else { Rgb([0.0, 0.5, 0.0]) })
}

#[test]
fn linear_images_become_maps() {
    let folder = tempfile::tempdir().unwrap();
    image().save(folder.path().join("a.exr")).unwrap();
    image().save(folder.path().join("a.hdr")).unwrap();
    let with_alpha = Rgba32FImage::from_fn(16, 8, |x, y| {
        let Rgb([red, green, blue]) = *image().get_pixel(x, y);
        Rgba([red, green, blue, 0.25])
    });
    with_alpha.save(folder.path().join("transparent.exr")).unwrap();
    let place = Location::File(folder.path().join("test.scene"));
    for name in ["a.exr", "a.hdr", "transparent.exr"] {
        let (scene, _) = lit(&format!("environment, \"{name}\""));
        let (assets, warnings) = AssetStore::default().load(&scene, &place, &Reading::unwatched(1 << 20)).unwrap();
        assert!(warnings.is_empty(), "{name}");
        let map = &assets.environment.as_ref().expect("a map").map;
        assert_eq!(
            (map.size(), map.radiance(DVec3::X), map.radiance(-DVec3::X)),
            (Some([16, 8]), [4.0, 0.0, 0.0], [0.0, 0.5, 0.0])
        );
        assert_eq!(assets.memory(), map.memory());
    }
    // White needs no file, and a preset none either.
    for (light, size) in [("environment", None), ("environment, \"preset:overcast\"", Some([1024, 512]))] {
        let (scene, _) = lit(light);
        let store = AssetStore::default();
        assert!(!store.has_changed(&scene, &Location::new("preset:studio")));
        let (assets, _) = store.load(&scene, &Location::new("preset:studio"), &Reading::unwatched(1 << 24)).unwrap();
        assert_eq!(assets.environment.and_then(|environment| environment.map.size()), size);
    }
}

#[test]
fn an_unchanged_image_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdr");
    image().save(&path).unwrap();
    let (store, place) = (AssetStore::default(), Location::File(folder.path().join("test.scene")));
    let load = |light: &str| {
        let (assets, _) = store.load(&lit(light).0, &place, &Reading::unwatched(1 << 20)).unwrap();
        assets.environment.expect("a map").map
    };
    let (scene, _) = lit("environment, \"a.hdr\"");
    let length = fs::metadata(&path).unwrap().len();
    assert_eq!((store.bytes_to_read(&scene, &place), store.has_changed(&scene, &place)), (length, true));
    let first = load("environment, \"a.hdr\"");
    assert_eq!((store.bytes_to_read(&scene, &place), store.has_changed(&scene, &place)), (0, false));
    // Turning it does not read it again.
    assert!(Arc::ptr_eq(&first, &load("environment, \"./a.hdr\", rotate 40")));
    Rgb32FImage::from_pixel(4, 2, Rgb([1.0; 3])).save(&path).unwrap();
    assert!(store.has_changed(&scene, &place));
    assert_eq!(load("environment, \"a.hdr\"").size(), Some([4, 2]));
    // A scene without an environment forgets it.
    drop(first);
    store.load(&lit("point, <1,2,3>").0, &place, &Reading::unwatched(1 << 20)).unwrap();
    assert!(store.has_changed(&scene, &place));
}

#[test]
fn what_is_wrong_with_an_image_is_said_at_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    image().save(path("studio.hdr")).unwrap();
    RgbImage::from_pixel(4, 2, Rgb([7; 3])).save(path("photo.png")).unwrap();
    fs::write(path("empty.exr"), "").unwrap();
    fs::write(path("page.hdr"), "<!doctype html><p>not found</p>").unwrap();
    let bytes = fs::read(path("studio.hdr")).unwrap();
    fs::write(path("cut.hdr"), &bytes[..bytes.len() - 3]).unwrap();
    let said = |name: &str| said_of(&format!("environment, \"{name}\", rotate 3"), folder.path());
    assert_snapshot!(said("studo.hdr"), @r#"
    test.scene:2:19: error: cannot read the image `FOLDER/studo.hdr`: there is no such file
        sky: environment, "studo.hdr", rotate 3;
                          ^^^^^^^^^^^ this environment cannot be used
        help: did you mean `FOLDER/studio.hdr`?
        help: a relative path starts from the folder of the scene
    "#);
    assert_snapshot!(said("photo.png"), @r#"
    test.scene:2:19: error: cannot read the image `FOLDER/photo.png`: it is a PNG image
        sky: environment, "photo.png", rotate 3;
                          ^^^^^^^^^^^ this environment cannot be used
        help: environments are images of the formats OpenEXR and Radiance HDR (exr, hdr)
        help: in other formats, nothing is brighter than white
    "#);
    assert_snapshot!(said("preset:skye"), @r#"
    test.scene:2:19: error: there is no built-in environment `preset:skye`
        sky: environment, "preset:skye", rotate 3;
                          ^^^^^^^^^^^^^ this environment
        help: did you mean `preset:sky`?
    "#);
    for (name, message) in [
        ("empty.exr", "cannot read the image `FOLDER/empty.exr`: the file is empty"),
        ("page.hdr", "it looks like a web page (HTML)"),
        ("cut.hdr", "the file ends too early"),
        (".", "it is a folder, not a file"),
        ("preset:gem", "there is no built-in environment `preset:gem`"),
    ] {
        let said = said(name);
        assert!(said.contains(message) && said.starts_with("test.scene:2:19: error:"), "{said}");
    }
    let (scene, source) = lit("environment, \"a.hdr\"");
    let failed = AssetStore::default().load(&scene, &Location::new("preset:studio"), &Reading::unwatched(1 << 20));
    let Err(AssetLoadError::Unusable(errors)) = failed else { panic!("{failed:?}") };
    assert_snapshot!(format!("{:#}", errors.located(&source)), @r#"
    test.scene:2:19: error: a built-in scene has no folder from which an environment could be read
        sky: environment, "a.hdr";
                          ^^^^^^^ this environment
        help: save the scene beside the environment, or name a built-in environment, `preset:NAME`
    "#);
}

#[test]
fn damaged_images_end_in_messages() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.exr", "a.hdr"] {
        let path = folder.path().join(name);
        Rgb32FImage::from_pixel(4, 2, Rgb([1.0, 2.0, 3.0])).save(&path).unwrap();
        let bytes = fs::read(&path).unwrap();
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 0xff;
            for damaged in [&bytes[..at], &changed] {
                fs::write(&path, damaged).unwrap();
                let said = said_of(&format!("environment, \"{name}\""), folder.path());
                assert!(said.is_empty() || said.starts_with("test.scene:2:19: "), "{said}");
            }
        }
    }
}

#[test]
fn what_is_odd_about_an_image_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let mut odd = Rgb32FImage::from_pixel(4, 4, Rgb([1.0; 3]));
    for (x, texel) in
        [[f32::NAN, 1.0, 1.0], [-0.5, -1.0, 0.0], [0.0, 0.0, -1e-9], [f32::INFINITY, 0.0, 0.0]].into_iter().enumerate()
    {
        odd.put_pixel(x as u32, 1, Rgb(texel));
    }
    odd.save(folder.path().join("odd.exr")).unwrap();
    Rgb32FImage::from_pixel(4, 2, Rgb([0.0; 3])).save(folder.path().join("black.exr")).unwrap();
    assert_snapshot!(said_of("environment, \"odd.exr\"", folder.path()), @r#"
    test.scene:2:19: warning: 1 texel has components that are not numbers; 0 is used
        sky: environment, "odd.exr";
                          ^^^^^^^^^ in this environment
    test.scene:2:19: warning: 2 texels have components below 0, 3.9 % of the light; 0 is used
        sky: environment, "odd.exr";
                          ^^^^^^^^^ in this environment
    test.scene:2:19: warning: 1 texel has components that are infinite or too large; 8.6e9 is used
        sky: environment, "odd.exr";
                          ^^^^^^^^^ in this environment
    test.scene:2:19: warning: the image has 4×4 texels; one that shows all directions is twice as wide as it is high
        sky: environment, "odd.exr";
                          ^^^^^^^^^ in this environment
    "#);
    // A little below 0 is usual.
    let mut little = Rgb32FImage::from_pixel(4, 2, Rgb([1.0; 3]));
    little.put_pixel(1, 1, Rgb([-0.1, 0.0, 1.0]));
    little.save(folder.path().join("little.exr")).unwrap();
    assert_eq!(said_of("environment, \"little.exr\"", folder.path()), "");
    assert!(said_of("environment, \"black.exr\"", folder.path()).contains("the image is black: it sends no light"));
    // There is no light that they could be a part of, or they are infinite.
    for (name, texel) in [("below.exr", [-1.0; 3]), ("red.exr", [f32::NEG_INFINITY, 1.0, 1.0])] {
        Rgb32FImage::from_pixel(4, 2, Rgb(texel)).save(folder.path().join(name)).unwrap();
        let said = said_of(&format!("environment, \"{name}\""), folder.path());
        assert!(said.contains("warning: 8 texels have components below 0; 0 is used\n"), "{said}");
    }
}

#[test]
fn memory_and_cancellation_end_the_reading_of_an_image() {
    let folder = tempfile::tempdir().unwrap();
    let place = Location::File(folder.path().join("test.scene"));
    Rgb32FImage::from_pixel(256, 128, Rgb([1.0; 3])).save(folder.path().join("a.exr")).unwrap();
    let (scene, source) = lit("environment, \"a.exr\"");
    let store = AssetStore::default();
    // 256·128 texels of three numbers of four bytes, twice while they are decoded.
    let needed = 256 * 128 * 24;
    let Err(AssetLoadError::Unusable(errors)) = store.load(&scene, &place, &Reading::unwatched(needed - 1)) else { panic!() };
    let said = format!("{:#}", errors.located(&source)).replace(&folder.path().display().to_string(), "FOLDER");
    assert!(said.contains("`FOLDER/a.exr` is too large: it needs 768.0 KiB, and 768.0 KiB are allowed"), "{said}");
    store.forget_refused();
    assert!(store.load(&scene, &place, &Reading::unwatched(needed)).is_ok());
    let Err(AssetLoadError::Unusable(errors)) =
        AssetStore::default().load(&lit("environment, \"preset:sky\"").0, &place, &Reading::unwatched(1 << 20))
    else {
        panic!()
    };
    assert!(errors.iter().any(|error| error.message().starts_with("`preset:sky` is too large: it needs 5")));
    // While it is read, and while it is decoded.
    for after in [0.0, 0.3] {
        let cancelled = AtomicBool::new(false);
        let cancel = |share: f64| cancelled.store(share >= after, Ordering::Relaxed);
        let reading = Reading { cancelled: &cancelled, progress: &cancel, ..Reading::unwatched(1 << 24) };
        let store = AssetStore::default();
        assert_eq!(store.load(&scene, &place, &reading).map(drop), Err(AssetLoadError::Cancelled));
        assert!(store.has_changed(&scene, &place), "it is tried again");
    }
}
