//! PLY, as text and binary of both byte orders.

use crate::mesh::Mesh;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// As words.
    Text,
    /// As bytes, the lowest first.
    Little,
    /// As bytes, the highest first.
    Big,
}

/// A file of vertices and faces. The vertices have further properties, which readers must skip.
/// Panics if a face has more than 255 corners.
pub fn file(mesh: &Mesh, encoding: Encoding) -> Vec<u8> {
    let format = match encoding {
        Encoding::Text => "ascii",
        Encoding::Little => "binary_little_endian",
        Encoding::Big => "binary_big_endian",
    };
    let header = format!(
        "ply\nformat {format} 1.0\ncomment made by shapes\nelement vertex {}\nproperty float x\nproperty uchar red\n\
         property float32 y\nproperty float z\nproperty list uchar short tags\nelement face {}\n\
         property list uchar int vertex_indices\nproperty double quality\nend_header\n",
        mesh.vertices.len(),
        mesh.faces.len()
    );
    let mut out = Writer { bytes: header.into_bytes(), encoding };
    for &[x, y, z] in &mesh.vertices {
        out.number(x, &x.to_le_bytes());
        out.number(200, &[200]);
        out.number(y, &y.to_le_bytes());
        out.number(z, &z.to_le_bytes());
        out.number(2, &[2]);
        out.number(-7, &(-7_i16).to_le_bytes());
        out.number(8, &8_i16.to_le_bytes());
        out.end_line();
    }
    for face in &mesh.faces {
        let count = u8::try_from(face.len()).expect("at most 255 corners");
        out.number(count, &[count]);
        for corner in face {
            out.number(corner, &corner.to_le_bytes());
        }
        out.number(0.5, &0.5_f64.to_le_bytes());
        out.end_line();
    }
    out.bytes
}

struct Writer {
    bytes: Vec<u8>,
    encoding: Encoding,
}

impl Writer {
    fn number(&mut self, value: impl std::fmt::Display, low_first: &[u8]) {
        match self.encoding {
            Encoding::Text => self.bytes.extend(format!("{value} ").bytes()),
            Encoding::Little => self.bytes.extend(low_first),
            Encoding::Big => self.bytes.extend(low_first.iter().rev()),
        }
    }

    fn end_line(&mut self) {
        if self.encoding == Encoding::Text {
            self.bytes.push(b'\n');
        }
    }
}
