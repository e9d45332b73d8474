//! A virtual display, and a simulated user of the program.

use pathmarch_testing::{Requirement, Test, missing};
use std::io::{BufRead, BufReader};
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _, EventMask, ImageFormat, InputFocus, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

/// Default timeout, seconds, generous for busy machines; `PATHMARCH_TEST_PATIENCE` overrides it.
const DEFAULT_TIMEOUT: u64 = 300;
/// Interval between screenshots.
const PAUSE: Duration = Duration::from_millis(25);
/// Interval between keys, as of a fast typist.
const KEY_PAUSE: Duration = Duration::from_millis(15);
/// Keysyms of keys without letters; X11/keysymdef.h.
const KEYSYMS: &[(&str, u32)] = &[
    ("Tab", 0xff09),
    ("Return", 0xff0d),
    ("Escape", 0xff1b),
    ("Home", 0xff50),
    ("Right", 0xff53),
    ("Down", 0xff54),
    ("F4", 0xffc1),
    ("F12", 0xffc9),
    ("Shift_L", 0xffe1),
    ("Control_L", 0xffe3),
    ("Delete", 0xffff),
];

const KEY_PRESS: u8 = 2;
const KEY_RELEASE: u8 = 3;
const BUTTON_PRESS: u8 = 4;
const BUTTON_RELEASE: u8 = 5;
const MOTION: u8 = 6;

/// Requirement: a display can be started.
pub static DISPLAY: Requirement = Requirement {
    variable: "PATHMARCH_REQUIRE_DISPLAY",
    missing: || {
        static MISSING: OnceLock<Option<String>> = OnceLock::new();
        MISSING.get_or_init(|| Screen::start().err()).clone()
    },
};

/// Kind of tests that open a window.
pub fn with_display(name: &str, test: fn()) -> [Test; 1] {
    [Test::requiring(name, &DISPLAY, test)]
}

/// Timeout of any wait.
fn timeout() -> Duration {
    let seconds = std::env::var("PATHMARCH_TEST_PATIENCE").ok().and_then(|seconds| seconds.parse().ok());
    Duration::from_secs(seconds.unwrap_or(DEFAULT_TIMEOUT))
}

/// A virtual display; stops when dropped.
pub struct Screen {
    server: Child,
    name: String,
}

impl Screen {
    /// Starts a display with a free number; the error is the reason why it cannot.
    pub fn start() -> Result<Self, String> {
        let arguments = ["-displayfd", "1", "-screen", "0", "1400x900x24", "-nolisten", "tcp", "-noreset"];
        let server = Command::new("Xvfb").args(arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let mut server = server.map_err(|error| format!("no display: Xvfb cannot be started: {error}"))?;
        let mut number = String::new();
        let read = BufReader::new(server.stdout.take().expect("a pipe")).read_line(&mut number);
        if read.is_err() || number.trim().is_empty() {
            let _ = server.kill();
            let _ = server.wait();
            return Err("no display: Xvfb ends at once".to_owned());
        }
        Ok(Self { server, name: format!(":{}", number.trim()) })
    }

    /// Starts the program in a window; `home` contains its preferences and recovery files.
    pub fn person(&self, home: &Path, scene: Option<&Path>) -> Person {
        self.person_with(home, scene, &[])
    }

    /// Starts the program with additional arguments.
    pub fn person_with(&self, home: &Path, scene: Option<&Path>, further: &[&str]) -> Person {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pathmarch"));
        command.arg("view").args(scene).args(["--timings", "--backend", "cpu"]).args(further);
        command.env("DISPLAY", &self.name).env("PATHMARCH_HOME", home.join("home")).env_remove("WAYLAND_DISPLAY");
        let mut program = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("it starts");
        let printed = Arc::<Mutex<String>>::default();
        let (errors, into) = (program.stderr.take().expect("a pipe"), printed.clone());
        std::thread::spawn(move || {
            for line in BufReader::new(errors).lines().map_while(Result::ok) {
                let mut printed = into.lock().expect("whole");
                printed.push_str(&line);
                printed.push('\n');
            }
        });
        let (connection, screen) = x11rb::connect(Some(&self.name)).expect("the display answers");
        let root = connection.setup().roots[screen].root;
        let mut person = Person { program, printed, connection, root, window: 0, keys: Vec::new() };
        let start = Instant::now();
        loop {
            if let Some(window) = person.find_window() {
                person.window = window;
                break;
            }
            if let Ok(Some(_)) = person.program.try_wait() {
                std::thread::sleep(PAUSE);
                let printed = person.printed();
                assert!(printed.contains("no window can be opened"), "{printed}");
                missing(DISPLAY.variable, printed);
            }
            assert!(start.elapsed() < timeout(), "no window: {}", person.printed());
            std::thread::sleep(PAUSE);
        }
        person.learn_keys();
        person.until("something is drawn", |person| person.printed().contains("window drawn"));
        person.focus();
        person
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// A simulated user; ends the program when dropped.
pub struct Person {
    program: Child,
    printed: Arc<Mutex<String>>,
    connection: RustConnection,
    root: Window,
    window: Window,
    /// Keysyms without and with Shift, and their keycode.
    keys: Vec<(u32, bool, u8)>,
}

impl Person {
    fn find_window(&self) -> Option<Window> {
        let children = self.connection.query_tree(self.root).ok()?.reply().ok()?.children;
        children.into_iter().find(|window| self.title_of(*window).is_some_and(|title| title.ends_with("pathmarch")))
    }

    fn title_of(&self, window: Window) -> Option<String> {
        let atom = |name: &str| Some(self.connection.intern_atom(false, name.as_bytes()).ok()?.reply().ok()?.atom);
        let name = atom("_NET_WM_NAME")?;
        let reply = self.connection.get_property(false, window, name, AtomEnum::ANY, 0, 1000).ok()?.reply().ok()?;
        String::from_utf8(reply.value).ok()
    }

    /// Title of the window.
    pub fn title(&self) -> String {
        self.title_of(self.window).unwrap_or_default()
    }

    /// Standard error of the program so far.
    pub fn printed(&self) -> String {
        self.printed.lock().expect("whole").clone()
    }

    pub fn is_running(&mut self) -> bool {
        matches!(self.program.try_wait(), Ok(None))
    }

    /// Gives the keyboard focus to the window.
    pub fn focus(&self) {
        // A window must be visible to get the focus.
        self.until("the window has the keyboard", |person| {
            let focus = person.connection.set_input_focus(InputFocus::PARENT, person.window, x11rb::CURRENT_TIME);
            let given = focus.is_ok_and(|cookie| cookie.check().is_ok());
            let now = person.connection.get_input_focus().ok().and_then(|cookie| cookie.reply().ok());
            given && now.is_some_and(|reply| reply.focus == person.window)
        });
    }

    fn learn_keys(&mut self) {
        let setup = self.connection.setup();
        let (first, last) = (setup.min_keycode, setup.max_keycode);
        let mapping =
            self.connection.get_keyboard_mapping(first, last - first + 1).expect("asked").reply().expect("keys");
        let each = usize::from(mapping.keysyms_per_keycode);
        for (keysyms, code) in mapping.keysyms.chunks(each).zip(first..=last) {
            for (keysym, shift) in keysyms.iter().take(2).zip([false, true]) {
                self.keys.push((*keysym, shift, code));
            }
        }
    }

    fn code(&self, name: &str) -> (u8, bool) {
        let named = KEYSYMS.iter().find(|(other, _)| *other == name).map(|(_, keysym)| *keysym);
        // Keysyms of Latin letters equal their character codes.
        let keysym = named.unwrap_or_else(|| u32::from(name.chars().next().expect("a key")));
        let key = self.keys.iter().find(|(other, ..)| *other == keysym);
        let (_, shift, code) = key.unwrap_or_else(|| panic!("no key for {name}"));
        (*code, *shift)
    }

    fn input(&self, kind: u8, detail: u8, [x, y]: [u16; 2]) {
        let sent =
            self.connection.xtest_fake_input(kind, detail, x11rb::CURRENT_TIME, self.root, x as i16, y as i16, 0);
        sent.expect("sent").check().expect("taken");
    }

    /// Presses a key while modifiers are held.
    pub fn key(&self, name: &str, held: &[&str]) {
        let (code, shift) = self.code(name);
        let mut held: Vec<u8> = held.iter().map(|name| self.code(name).0).collect();
        if shift {
            held.push(self.code("Shift_L").0);
        }
        held.iter().for_each(|code| self.input(KEY_PRESS, *code, [0; 2]));
        self.input(KEY_PRESS, code, [0; 2]);
        self.input(KEY_RELEASE, code, [0; 2]);
        held.iter().rev().for_each(|code| self.input(KEY_RELEASE, *code, [0; 2]));
        std::thread::sleep(KEY_PAUSE);
    }

    pub fn keys(&self, name: &str, times: usize) {
        (0..times).for_each(|_| self.key(name, &[]));
    }

    pub fn text(&self, text: &str) {
        text.chars().for_each(|letter| self.key(&letter.to_string(), &[]));
    }

    /// Screen position of a point of the window.
    fn on_screen(&self, [x, y]: [u16; 2]) -> [u16; 2] {
        let place = self.connection.translate_coordinates(self.window, self.root, x as i16, y as i16);
        let place = place.expect("asked").reply().expect("a place");
        [place.dst_x as u16, place.dst_y as u16]
    }

    pub fn click(&self, x: u16, y: u16) {
        let at = self.on_screen([x, y]);
        self.input(MOTION, 0, at);
        self.input(BUTTON_PRESS, 1, at);
        self.input(BUTTON_RELEASE, 1, at);
        // Wait for the click's effect before typing.
        self.still();
    }

    /// Presses the button and moves in steps until a condition holds in a stable picture, then releases it. However
    /// slow the program is, it sees the press in one frame and the movement in later ones.
    #[track_caller]
    pub fn drag_until(&self, from: [u16; 2], step: [i32; 2], what: &str, holds: impl Fn(&Self) -> bool) {
        const FAR: i32 = 20;
        let from = self.on_screen(from);
        self.input(MOTION, 0, from);
        self.input(BUTTON_PRESS, 1, from);
        let steps = std::cell::Cell::new(0);
        self.until(what, |person| {
            // Away first, then back and forth, as space is limited.
            let count = steps.replace(steps.get() + 1);
            let count = if count < FAR { count } else { FAR / 2 + (count % FAR - FAR / 2).abs() };
            person.input(MOTION, 0, [0, 1].map(|axis| (i32::from(from[axis]) + step[axis] * count).max(0) as u16));
            if !holds(person) {
                return false;
            }
            person.still();
            holds(person)
        });
        self.input(BUTTON_RELEASE, 1, from);
    }

    /// Size of the window, pixels.
    pub fn size(&self) -> [u16; 2] {
        let geometry = self.connection.get_geometry(self.window).ok().and_then(|cookie| cookie.reply().ok());
        geometry.map_or([0; 2], |geometry| [geometry.width, geometry.height])
    }

    pub fn configure(&self, values: &ConfigureWindowAux) {
        self.connection.configure_window(self.window, values).expect("sent").check().expect("taken");
    }

    /// Shows or hides the window.
    pub fn show(&self, shown: bool) {
        let sent =
            if shown { self.connection.map_window(self.window) } else { self.connection.unmap_window(self.window) };
        sent.expect("sent").check().expect("taken");
    }

    /// Asks the window to close, as a window manager does.
    pub fn close(&self) {
        let atom = |name: &str| {
            self.connection.intern_atom(false, name.as_bytes()).expect("asked").reply().expect("an atom").atom
        };
        let data = [atom("WM_DELETE_WINDOW"), x11rb::CURRENT_TIME, 0, 0, 0];
        let event = ClientMessageEvent::new(32, self.window, atom("WM_PROTOCOLS"), data);
        self.connection
            .send_event(false, self.window, EventMask::NO_EVENT, event)
            .expect("sent")
            .check()
            .expect("taken");
    }

    /// Waits until the program ends.
    pub fn ends(&mut self) -> ExitStatus {
        let start = Instant::now();
        loop {
            if let Some(status) = self.program.try_wait().expect("it can be waited for") {
                return status;
            }
            assert!(start.elapsed() < timeout(), "it does not end: {}", self.printed());
            std::thread::sleep(PAUSE);
        }
    }

    /// Kills the program.
    pub fn kill(&mut self) {
        self.program.kill().expect("killed");
        assert_eq!(self.program.wait().expect("it can be waited for").signal(), Some(9));
    }

    /// Screenshot of the window.
    pub fn image(&self) -> Image {
        let [width, height] = self.size();
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, self.window, 0, 0, width, height, !0);
        // While the window is resized there may be none.
        let data = image.ok().and_then(|cookie| cookie.reply().ok()).map_or_else(Vec::new, |reply| reply.data);
        let pixels = data.chunks_exact(4).map(|pixel| [pixel[2], pixel[1], pixel[0]]).collect();
        Image { width: usize::from(width), height: usize::from(height), pixels }
    }

    /// Waits until a condition holds.
    #[track_caller]
    pub fn until(&self, what: &str, holds: impl Fn(&Self) -> bool) {
        let start = Instant::now();
        while !holds(self) {
            assert!(start.elapsed() < timeout(), "waited in vain until {what}: {:?}\n{}", self.title(), self.printed());
            std::thread::sleep(PAUSE);
        }
    }

    /// Waits until the picture is stable for a moment.
    #[track_caller]
    pub fn still(&self) {
        let start = Instant::now();
        let mut last = self.image();
        let mut since = Instant::now();
        while since.elapsed() < Duration::from_millis(600) {
            assert!(start.elapsed() < timeout(), "the picture never becomes stable");
            std::thread::sleep(Duration::from_millis(100));
            let now = self.image();
            // A cursor may blink.
            if now.differs_from(&last) > 100 {
                since = Instant::now();
            }
            last = now;
        }
    }
}

impl Drop for Person {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("window-{}.png", self.program.id()));
            let seen = self.image().save(&path);
            eprintln!("{}\n{:?}, seen in {}: {seen:?}", self.printed(), self.program.try_wait(), path.display());
        }
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// A screenshot: red, green and blue of each pixel.
pub struct Image {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl Image {
    pub fn count(&self, is_it: impl Fn([u8; 3]) -> bool) -> usize {
        self.pixels.iter().filter(|pixel| is_it(**pixel)).count()
    }

    /// Pixels of a region: left, top, right and bottom from 0 to 1.
    pub fn count_in(&self, part: [f64; 4], is_it: impl Fn([u8; 3]) -> bool) -> usize {
        let inside = |at: usize| {
            let (x, y) = ((at % self.width) as f64 / self.width as f64, (at / self.width) as f64 / self.height as f64);
            (part[0]..part[2]).contains(&x) && (part[1]..part[3]).contains(&y)
        };
        let pixels = self.pixels.iter().enumerate();
        pixels.filter(|(at, pixel)| inside(*at) && is_it(**pixel)).count()
    }

    /// Centre of matching pixels; the corner if there are none.
    pub fn centre_of(&self, is_it: impl Fn([u8; 3]) -> bool) -> [u16; 2] {
        let places: Vec<usize> = (0..self.pixels.len()).filter(|at| is_it(self.pixels[*at])).collect();
        let mean = |place: fn(usize, usize) -> usize| {
            let sum: usize = places.iter().map(|at| place(*at, self.width)).sum();
            (sum / places.len().max(1)) as u16
        };
        [mean(|at, width| at % width), mean(|at, width| at / width)]
    }

    /// Writes the screenshot to a file, for inspection.
    fn save(&self, path: &Path) -> image::ImageResult<()> {
        let bytes = self.pixels.iter().flatten().copied().collect::<Vec<u8>>();
        image::save_buffer(path, &bytes, self.width as u32, self.height as u32, image::ColorType::Rgb8)
    }

    /// Number of clearly different pixels.
    pub fn differs_from(&self, other: &Self) -> usize {
        if self.pixels.len() != other.pixels.len() || self.width != other.width {
            return usize::MAX;
        }
        let far = |a: &[u8; 3], b: &[u8; 3]| a.iter().zip(b).any(|(a, b)| a.abs_diff(*b) > 12);
        self.pixels.iter().zip(&other.pixels).filter(|(a, b)| far(a, b)).count()
    }
}
