//! Packets of the image viewer tev (<https://github.com/Tom94/tev>, `src/Ipc.cpp`), by which a
//! program shows a picture while it grows.
//!
//! A packet is, little-endian: its length in bytes (4, themselves counted), its kind (1), and what
//! the kind needs. Texts end with a zero byte. Pixels are 32-bit floats, scene-linear.

use snowgrain_film::{Layer, Picture, PixelRect};

/// Pixels along an edge of an update: 768 KiB, which the viewer's first buffer (1 MiB) holds.
const TILE: u32 = 256;

/// Kinds of packets, of those that are sent.
#[derive(Clone, Copy)]
enum Kind {
    CreateImage = 4,
    /// Of several channels, one after another.
    UpdateImageV2 = 5,
}

/// Asks for an empty picture with the channels R, G and B, and that it be shown; one of the same name
/// is replaced.
#[must_use]
pub fn create_image(name: &str, width: u32, height: u32) -> Vec<u8> {
    let mut packet = Packet::new(Kind::CreateImage);
    packet.put(&[1]);
    packet.text(name);
    packet.numbers(&[width, height, Layer::COLOUR.len() as u32]);
    Layer::COLOUR.iter().for_each(|layer| packet.text(layer.name()));
    packet.finish()
}

/// The colours of a picture, over its window, as packets of one tile each; `None` for a picture
/// without colour.
pub fn update_image<'a>(
    name: &'a str,
    picture: &'a Picture,
) -> Option<impl Iterator<Item = Vec<u8>> + 'a> {
    let colour = picture.colour().ok()?;
    let window = picture.window();
    Some(window.tiles(TILE).map(move |tile| update_tile(name, colour, window, tile)))
}

fn update_tile(name: &str, colour: [&[f32]; 3], window: PixelRect, tile: PixelRect) -> Vec<u8> {
    let mut packet = Packet::new(Kind::UpdateImageV2);
    packet.put(&[0]);
    packet.text(name);
    packet.numbers(&[Layer::COLOUR.len() as u32]);
    Layer::COLOUR.iter().for_each(|layer| packet.text(layer.name()));
    packet.numbers(&[tile.x0, tile.y0, tile.width(), tile.height()]);
    for channel in colour {
        for y in tile.y0..tile.y1 {
            let first = window.index(tile.x0, y).unwrap_or(0);
            let row = &channel[first..first + tile.width() as usize];
            row.iter().for_each(|value| packet.put(&value.to_le_bytes()));
        }
    }
    packet.finish()
}

/// A packet that is being written.
struct Packet(Vec<u8>);

impl Packet {
    fn new(kind: Kind) -> Self {
        // The length is known at the end.
        Self(vec![0, 0, 0, 0, kind as u8])
    }

    fn put(&mut self, bytes: &[u8]) {
        self.0.extend_from_slice(bytes);
    }

    fn numbers(&mut self, numbers: &[u32]) {
        numbers.iter().for_each(|number| self.put(&number.to_le_bytes()));
    }

    /// A zero byte would end the text, so it ends there.
    fn text(&mut self, text: &str) {
        let bytes = text.as_bytes();
        let length = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
        self.put(&bytes[..length]);
        self.put(&[0]);
    }

    fn finish(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_have_the_bytes_that_the_viewer_reads() {
        let head = [26, 0, 0, 0, 4, 1, b's', 0, 5, 0, 0, 0, 3, 0, 0, 0, 3, 0, 0, 0];
        assert_eq!(create_image("s\0cut", 5, 3), [&head[..], b"R\0G\0B\0"].concat());
    }

    #[test]
    fn tiles_of_an_update_cover_the_window_once() {
        let window = PixelRect::new(10, 3, 10 + 300, 3 + 2);
        let mut picture = Picture::new(400, 9, window).unwrap();
        for (channel, layer) in (0u16..).zip(Layer::COLOUR) {
            let values = (0..600).map(|index| f32::from(channel * 1000 + index)).collect();
            picture.set_layer(layer, values).unwrap();
        }
        let packets: Vec<_> = update_image("s", &picture).unwrap().collect();
        let head: Vec<_> = packets.iter().map(|packet| packet[18..34].to_vec()).collect();
        assert_eq!(head[0], [10, 0, 0, 0, 3, 0, 0, 0, 246, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(head[1], [0, 1, 0, 0, 3, 0, 0, 0, 54, 0, 0, 0, 2, 0, 0, 0]);
        let floats: Vec<f32> =
            packets[1][34..].as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect();
        let row = |first: u16| (first..first + 54).map(f32::from);
        let expected: Vec<f32> =
            [246, 546, 1246, 1546, 2246, 2546].into_iter().flat_map(row).collect();
        assert_eq!(floats, expected);
        assert!(
            update_image("s", &Picture::new(4, 4, PixelRect::new(0, 0, 4, 4)).unwrap()).is_none()
        );
    }
}
