//! A viewer on the network is shown the picture, and cannot disturb the render.

use crate::Workplace;
use snowgrain_film::{Layer, PixelRect};
use snowgrain_formats::image::read_picture;
use std::io::Read;
use std::net::TcpListener;
use std::thread::JoinHandle;

/// What a viewer was told.
#[derive(Debug, Default)]
struct Seen {
    created: Vec<(String, [u32; 2], Vec<String>)>,
    updates: u32,
    /// Pixels as they stand at the end, channel by channel, row-major over the whole picture.
    channels: [Vec<f32>; 3],
}

/// Takes pieces of a packet from its front.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take(&mut self, count: usize) -> &[u8] {
        let (head, tail) = self.0.split_at(count);
        self.0 = tail;
        head
    }

    fn number(&mut self) -> u32 {
        u32::from_le_bytes(self.take(4).try_into().unwrap())
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).unwrap();
        let text = String::from_utf8(self.take(end).to_vec()).unwrap();
        self.take(1);
        text
    }
}

impl Seen {
    /// Takes one packet, without its length.
    fn packet(&mut self, packet: &[u8]) {
        let mut fields = Fields(packet);
        let kind = fields.take(2)[0]; // and whether it is to be focused
        let name = fields.text();
        match kind {
            4 => {
                let size = [fields.number(), fields.number()];
                let count = fields.number();
                let names = (0..count).map(|_| fields.text()).collect();
                self.channels = [(); 3].map(|()| vec![f32::NAN; (size[0] * size[1]) as usize]);
                self.created.push((name, size, names));
            }
            5 => {
                self.updates += 1;
                let (of, size, _) = self.created.last().unwrap();
                assert_eq!(*of, name);
                assert_eq!(fields.number(), 3);
                let names = [fields.text(), fields.text(), fields.text()];
                assert_eq!(names, ["R", "G", "B"]);
                let [x, y, width, height] = [(); 4].map(|()| fields.number());
                for channel in &mut self.channels {
                    for row in y..y + height {
                        for column in x..x + width {
                            let value = f32::from_bits(fields.number());
                            channel[(row * size[0] + column) as usize] = value;
                        }
                    }
                }
            }
            kind => panic!("a packet of kind {kind}"),
        }
        assert!(fields.0.is_empty(), "bytes are left over");
    }
}

/// A viewer that takes one connection and reads it to its end.
fn viewer() -> (String, JoinHandle<Seen>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let thread = std::thread::spawn(move || {
        let (mut connection, _) = listener.accept().unwrap();
        let mut bytes = Vec::new();
        connection.read_to_end(&mut bytes).unwrap();
        let (mut seen, mut rest) = (Seen::default(), &bytes[..]);
        while !rest.is_empty() {
            let length = u32::from_le_bytes(rest[..4].try_into().unwrap()) as usize;
            seen.packet(&rest[4..length]);
            rest = &rest[length..];
        }
        seen
    });
    (address, thread)
}

#[test]
fn a_viewer_is_shown_the_picture_as_it_ends() {
    let place = Workplace::new();
    let (address, thread) = viewer();
    let crop = ["--crop", "7,3,41,44", "--display-server", &address, "-o", "a.exr"];
    let said = place.tiny(&crop).stderr;
    assert_eq!(said, "");
    let seen = thread.join().unwrap();
    let names = ["R", "G", "B"].map(str::to_owned).to_vec();
    assert_eq!(seen.created, [("snowy-teapot".to_owned(), [48, 48], names)]);
    assert!(seen.updates >= 1);
    let picture = read_picture(&place.path("a.exr")).unwrap();
    let whole = PixelRect::new(0, 0, 48, 48);
    for (shown, layer) in seen.channels.iter().zip(Layer::COLOUR) {
        let values = picture.layer(layer).unwrap();
        for (index, &shown) in shown.iter().enumerate() {
            let (x, y) = whole.pixel(index);
            match picture.window().index(x, y) {
                Some(there) => assert_eq!(shown, values[there], "({x}, {y})"),
                None => assert!(shown.is_nan(), "({x}, {y}) lies outside the crop"),
            }
        }
    }
}

#[test]
fn a_viewer_that_is_absent_or_leaves_changes_nothing_but_a_line() {
    let place = Workplace::new();
    place.tiny(&["-o", "alone.exr"]);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    drop(listener); // nobody listens there now
    let tiny = [&["render", "snowy-teapot"], &crate::TINY[..]].concat();
    let absent = ["--display-server", &address, "-o", "absent.exr"];
    let said = place.succeed(&[&tiny[..], &absent].concat()).stderr;
    let lines: Vec<_> = said.lines().filter(|line| line.contains("viewer")).collect();
    let [line] = lines[..] else { panic!("{said}") };
    assert!(line.contains(&address) && line.contains("refused"), "{line}");
    assert_eq!(place.bytes("absent.exr"), place.bytes("alone.exr"));

    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let leaves = std::thread::spawn(move || drop(listener.accept().unwrap()));
    place.succeed(&[&tiny[..], &["--display-server", &address, "-o", "left.exr"]].concat());
    leaves.join().unwrap();
    assert_eq!(place.bytes("left.exr"), place.bytes("alone.exr"));
}
