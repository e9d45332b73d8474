//! Every word of the scene language as Markdown: `cargo run --release -p pathmarch-scene --example reference`.

fn main() {
    print!("{}", pathmarch_scene::reference::page());
}
