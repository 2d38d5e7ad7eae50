//! Meshopt compression, modes `TRIANGLES` and `INDICES`: vertex indices.
//!
//! Triangles that follow one another share edges and vertices. The decoder keeps the last 16 edges
//! and vertices, and a code byte for each triangle names its edge and its third vertex among them.
//! `next` is the lowest index that was not used yet, and `last` the last index that was given by a
//! difference.

use super::bytes::{Bytes, Damage};

/// First bytes of the streams: triangles and other indices, version 1 of each.
const TRIANGLES: u8 = 0xE1;
const INDICES: u8 = 0xD1;

const INDICES_TAIL: usize = 4;

const TABLE: usize = 16;

const QUEUE: u32 = 16;

/// A nibble of a code that stands for an index in the data.
const EXPLICIT: u8 = 0xF;

/// The last 16 entries, the latest first.
struct Queue<T> {
    entries: [T; QUEUE as usize],
    /// Number of entries that were ever added.
    count: u32,
}

impl<T: Copy + Default> Queue<T> {
    fn new() -> Self {
        Self { entries: [T::default(); QUEUE as usize], count: 0 }
    }

    fn push(&mut self, entry: T) {
        if let Some(place) = self.entries.get_mut((self.count % QUEUE) as usize) {
            *place = entry;
        }
        // After the first round, only the place in the round matters.
        self.count = if self.count == 2 * QUEUE - 1 { QUEUE } else { self.count + 1 };
    }

    /// The entry that was added `age` entries before the latest one.
    fn get(&self, age: u8) -> Result<T, Damage> {
        let at = self.count.checked_sub(1 + u32::from(age)).ok_or("it refers to triangles before the first")?;
        self.entries.get((at % QUEUE) as usize).copied().ok_or("it refers to triangles before the first")
    }
}

struct Triangles<'a> {
    data: Bytes<'a>,
    table: &'a [u8],
    next: u32,
    last: u32,
    edges: Queue<[u32; 2]>,
    vertices: Queue<u32>,
}

/// `count` is a multiple of three. Complexity: O(`count`).
pub fn decode_triangles(bytes: &[u8], count: usize) -> Result<Vec<u32>, Damage> {
    let mut stream = Bytes(bytes);
    if stream.byte()? != TRIANGLES {
        return Err("its first byte is not the header of triangles");
    }
    let table = stream.take_tail(TABLE)?;
    let is_valid = |byte: &u8| byte >> 4 != EXPLICIT && byte & 0xF != EXPLICIT;
    if !table.iter().all(is_valid) {
        return Err("its table has an invalid entry");
    }
    let codes = stream.take(count / 3)?;
    let mut state = Triangles { data: stream, table, next: 0, last: 0, edges: Queue::new(), vertices: Queue::new() };
    let mut indices = Vec::with_capacity(count);
    for &code in codes {
        indices.extend(state.triangle(code)?);
    }
    state.data.finish()?;
    Ok(indices)
}

impl Triangles<'_> {
    fn triangle(&mut self, code: u8) -> Result<[u32; 3], Damage> {
        let (high, low) = (code >> 4, code & 0xF);
        if high < 0xF { self.beside_edge(high, low) } else { self.apart(low) }
    }

    fn beside_edge(&mut self, edge: u8, third: u8) -> Result<[u32; 3], Damage> {
        let [a, b] = self.edges.get(edge)?;
        let c = match third {
            0 => self.unused(),
            1..0xD => self.vertices.get(third)?,
            0xD | 0xE => {
                self.last = if third == 0xD { self.last.wrapping_sub(1) } else { self.last.wrapping_add(1) };
                self.last
            }
            _ => self.explicit()?,
        };
        self.edges.push([c, b]);
        self.edges.push([a, c]);
        if !(1..0xD).contains(&third) {
            self.vertices.push(c);
        }
        Ok([a, b, c])
    }

    /// A triangle whose vertices are given one by one: by an entry of the table, or by the data.
    fn apart(&mut self, low: u8) -> Result<[u32; 3], Damage> {
        let code = match self.table.get(usize::from(low)) {
            Some(&code) if low < 0xE => code,
            _ => self.data.byte()?,
        };
        if low >= 0xE && code == 0 {
            self.next = 0;
        }
        let a = if low == 0xF { self.explicit()? } else { self.unused() };
        let (second, third) = (code >> 4, code & 0xF);
        let b = self.vertex(second)?;
        let c = self.vertex(third)?;
        for edge in [[b, a], [c, b], [a, c]] {
            self.edges.push(edge);
        }
        self.vertices.push(a);
        for (vertex, nibble) in [(b, second), (c, third)] {
            if matches!(nibble, 0 | EXPLICIT) {
                self.vertices.push(vertex);
            }
        }
        Ok([a, b, c])
    }

    /// The vertex of a nibble: the next unused one, an earlier one, or one in the data.
    fn vertex(&mut self, nibble: u8) -> Result<u32, Damage> {
        match nibble {
            0 => Ok(self.unused()),
            EXPLICIT => self.explicit(),
            age => self.vertices.get(age - 1),
        }
    }

    fn unused(&mut self) -> u32 {
        let index = self.next;
        self.next = index.wrapping_add(1);
        index
    }

    fn explicit(&mut self) -> Result<u32, Damage> {
        let number = self.data.varint()?;
        self.last = self.last.wrapping_add((number >> 1) ^ (number & 1).wrapping_neg());
        Ok(self.last)
    }
}

pub fn decode_sequence(bytes: &[u8], count: usize) -> Result<Vec<u32>, Damage> {
    let mut stream = Bytes(bytes);
    if stream.byte()? != INDICES {
        return Err("its first byte is not the header of indices");
    }
    stream.take_tail(INDICES_TAIL)?;
    // Each index takes a byte or more, so that `count` is at most the length of the stream.
    if count > stream.0.len() {
        return Err("it ends too early");
    }
    let mut last = [0_u32; 2];
    let mut indices = Vec::with_capacity(count);
    for _ in 0..count {
        let number = stream.varint()?;
        let [even, odd] = &mut last;
        let baseline = if number & 1 == 0 { even } else { odd };
        *baseline = baseline.wrapping_add((number >> 2) ^ (number >> 1 & 1).wrapping_neg());
        indices.push(*baseline);
    }
    stream.finish()?;
    Ok(indices)
}
