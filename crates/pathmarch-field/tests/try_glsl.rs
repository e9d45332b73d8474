use pathmarch_field::custom_sdf::{Code, glsl::Shader};
#[test]
fn all() {
    let mut failed = 0;
    for dir in ["tests/glsl", "tests/glsl/quick"] {
        let mut files: Vec<_> = std::fs::read_dir(dir).unwrap().map(|f| f.unwrap().path()).filter(|p| p.is_file()).collect();
        files.sort();
        for file in files {
            let text = std::fs::read_to_string(&file).unwrap();
            let result = Shader::read(&text, None, &[]).and_then(|s| { let c = Code::of_shader("x", &s); if c.is_err() && std::env::var("SHOW").is_ok() { println!("{}", s.debug()); } c.map(|c| (s, c)) });
            match result {
                Ok((s, _)) => println!("{}: ok {} {:?} {:?}", file.display(), s.function, s.params.iter().map(|p| (p.name.clone(), p.default)).collect::<Vec<_>>(), s.warnings),
                Err(faults) => { failed += 1; for f in faults { println!("{}: {} [{}] {:?} {:?}", file.display(), f.message, f.label, f.range.clone().map(|r| &text[r]), f.help); } }
            }
        }
    }
    assert_eq!(failed, 0);
}
