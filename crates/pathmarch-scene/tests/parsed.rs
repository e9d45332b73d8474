//! Scenes that tests parse, and what the parser reports of them.

use pathmarch_scene::Scene;

const HEAD: &str = "pathmarch 1\ncamera { position 0 1 5; target 0 1 0 }\n";

/// Scene of a text below a camera.
pub fn scene(text: &str) -> Scene {
    Scene::parse("scene.kdl", &format!("{HEAD}{text}")).expect("a valid scene")
}

/// Messages of the warnings whose code ends with this.
pub fn warnings(text: &str, code: &str) -> Vec<String> {
    let found = scene(text).warnings.into_iter().filter(|warning| warning.code.ends_with(code));
    found.map(|warning| warning.message).collect()
}

/// Messages of the mistakes.
pub fn mistakes(text: &str) -> Vec<String> {
    match Scene::parse("scene.kdl", &format!("{HEAD}{text}")) {
        Err(error) => error.mistakes().iter().map(|mistake| mistake.message.clone()).collect(),
        Ok(_) => panic!("{text} has no mistakes"),
    }
}
