//! Meshopt compression, mode `ATTRIBUTES`: elements of `stride` bytes, as differences to the
//! element before.
//!
//! Elements come in blocks of at most 256. A block stores the first bytes of all its elements, then
//! the second ones, and so on: a *plane* for each byte of an element. A plane consists of groups of
//! 16 bytes, each packed with 0, 1, 2, 4 or 8 bits a byte. Bytes that do not fit follow their
//! group. The mode of four planes, a *channel*, determines how differences become values: bytes,
//! 16-bit numbers, or a 32-bit number by exclusive or. Version 0 only has bytes.

use super::bytes::{Bytes, Damage};

/// First byte of a stream of version 0 and 1.
const HEADER_0: u8 = 0xA0;
const HEADER_1: u8 = 0xA1;

const GROUP: usize = 16;

const BLOCK: usize = 256;

const BLOCK_BYTES: usize = 8192;

/// Minimum length of the tail of version 0 and 1.
const TAIL_0: usize = 32;
const TAIL_1: usize = 24;

/// Bits for each byte of a group, by the group's header. Version 1 has two tables, of which the
/// control mode of a plane selects one.
const BITS_0: [u32; 4] = [0, 2, 4, 8];
const BITS_1: [[u32; 4]; 2] = [[0, 1, 2, 4], [1, 2, 4, 8]];

/// One byte of each element of a block.
type Plane = [u8; BLOCK];

/// `stride` is a multiple of 4 from 4 to 256. Complexity: O(`count` · `stride`).
pub fn decode(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, Damage> {
    let mut stream = Bytes(bytes);
    let channel_count = stride / 4;
    // Version 0 has no modes and no controls.
    let (mode_count, least_tail) = match stream.byte()? {
        HEADER_0 => (0, TAIL_0),
        HEADER_1 => (channel_count, TAIL_1),
        _ => return Err("its first byte is not the header of attributes"),
    };
    let mut tail = Bytes(stream.take_tail((stride + mode_count).max(least_tail))?);
    let mut modes: Vec<Mode> =
        tail.take_tail(mode_count)?.iter().map(|&byte| Mode::new(byte)).collect::<Result<_, _>>()?;
    modes.resize(channel_count, Mode::Bytes);
    let mut previous: Vec<[u8; 4]> = tail.take_tail(stride)?.as_chunks::<4>().0.to_vec();

    let block = (BLOCK_BYTES / stride / GROUP * GROUP).min(BLOCK);
    let mut decoded = vec![0; count * stride];
    let mut planes: [Plane; 4] = [[0; BLOCK]; 4];
    for elements in decoded.chunks_mut(block * stride) {
        let element_count = elements.len() / stride;
        let controls = stream.take(mode_count)?;
        for (channel, (previous, &mode)) in previous.iter_mut().zip(&modes).enumerate() {
            for (at, plane) in planes.iter_mut().enumerate() {
                let control = controls.get(channel).map(|byte| byte >> (2 * at) & 3);
                read_plane(&mut stream, plane, element_count, control)?;
            }
            let [a, b, c, d] = &planes;
            let differences = a.iter().zip(b).zip(c).zip(d).map(|(((a, b), c), d)| [*a, *b, *c, *d]);
            for (element, difference) in elements.chunks_exact_mut(stride).zip(differences) {
                *previous = mode.apply(*previous, difference);
                if let Some(place) = element.get_mut(4 * channel..4 * channel + 4) {
                    place.copy_from_slice(previous);
                }
            }
        }
    }
    stream.finish()?;
    Ok(decoded)
}

/// Reads the plane of `count` elements. `control` is its control mode in version 1.
fn read_plane(stream: &mut Bytes, plane: &mut Plane, count: usize, control: Option<u8>) -> Result<(), Damage> {
    let bits = match control {
        None => BITS_0,
        Some(0) => BITS_1[0],
        Some(1) => BITS_1[1],
        Some(2) => {
            plane.fill(0);
            return Ok(());
        }
        Some(_) => {
            let bytes = stream.take(count)?;
            plane.iter_mut().zip(bytes).for_each(|(place, byte)| *place = *byte);
            return Ok(());
        }
    };
    let group_count = count.div_ceil(GROUP);
    let headers = stream.take(group_count.div_ceil(4))?;
    let headers = headers.iter().flat_map(|byte| [0, 2, 4, 6].map(|shift| byte >> shift & 3));
    let groups = plane.as_chunks_mut::<GROUP>().0;
    for (group, header) in groups.iter_mut().take(group_count).zip(headers) {
        let bits = bits.get(usize::from(header)).copied().unwrap_or_default();
        read_group(stream, group, bits)?;
    }
    Ok(())
}

fn read_group(stream: &mut Bytes, group: &mut [u8; GROUP], bits: u32) -> Result<(), Damage> {
    if bits == 0 {
        group.fill(0);
        return Ok(());
    }
    let packed = stream.take(GROUP * bits as usize / 8)?;
    if bits == 8 {
        group.iter_mut().zip(packed).for_each(|(place, byte)| *place = *byte);
        return Ok(());
    }
    // All bits set: the byte does not fit, and follows the group.
    let escape = (1 << bits) - 1;
    let per_byte = 8 / bits as usize;
    for (places, byte) in group.chunks_mut(per_byte).zip(packed) {
        for (at, place) in (0..).zip(places) {
            // One bit each: from the lowest bit. Otherwise: from the highest bits.
            let shift = if bits == 1 { at } else { 8 - bits * (at + 1) };
            *place = byte >> shift & escape;
        }
    }
    for place in group.iter_mut().filter(|place| **place == escape) {
        *place = stream.byte()?;
    }
    Ok(())
}

/// How four bytes of an element follow from the bytes of the previous element.
#[derive(Clone, Copy)]
enum Mode {
    Bytes,
    Shorts,
    /// A 32-bit number, rotated to the left by this many bits, then joined by exclusive or.
    Xor(u32),
}

impl Mode {
    fn new(byte: u8) -> Result<Self, Damage> {
        match (byte & 0xF, byte >> 4) {
            (0, 0) => Ok(Self::Bytes),
            (1, 0) => Ok(Self::Shorts),
            (2, rotation) => Ok(Self::Xor(u32::from(rotation))),
            _ => Err("a channel has an unknown mode"),
        }
    }

    fn apply(self, previous: [u8; 4], difference: [u8; 4]) -> [u8; 4] {
        match self {
            Self::Bytes => {
                let [a, b, c, d] = previous;
                let [da, db, dc, dd] = difference.map(|byte| (byte >> 1) ^ (byte & 1).wrapping_neg());
                [a.wrapping_add(da), b.wrapping_add(db), c.wrapping_add(dc), d.wrapping_add(dd)]
            }
            Self::Shorts => {
                let shorts = |[a, b, c, d]: [u8; 4]| [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])];
                let ([a, b], [da, db]) = (shorts(previous), shorts(difference));
                let add = |a: u16, d: u16| a.wrapping_add((d >> 1) ^ (d & 1).wrapping_neg()).to_le_bytes();
                let ([a, b], [c, d]) = (add(a, da), add(b, db));
                [a, b, c, d]
            }
            Self::Xor(rotation) => {
                let difference = u32::from_le_bytes(difference).rotate_left(rotation);
                (u32::from_le_bytes(previous) ^ difference).to_le_bytes()
            }
        }
    }
}

/// Filter `EXPONENTIAL`: numbers of 32 bits, of which 8 are an exponent and 24 an integer, become
/// floats. Exact; exponents beyond ±100, which encoders do not write, are taken as they are.
pub fn expand_exponents(bytes: &mut [u8]) {
    for number in bytes.as_chunks_mut::<4>().0 {
        let packed = i32::from_le_bytes(*number);
        let (exponent, mantissa) = (packed >> 24, packed << 8 >> 8);
        // A power of two from 2^-128 to 2^127, by its bits as f64: the product is exact.
        let power = f64::from_bits(((1023 + i64::from(exponent)) as u64) << 52);
        *number = ((f64::from(mantissa) * power) as f32).to_le_bytes();
    }
}
