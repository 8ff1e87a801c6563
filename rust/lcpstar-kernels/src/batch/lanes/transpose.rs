//! Numbers of several problems, one problem per lane.

use crate::batch::io::Numbers;
use crate::small::lane::{BLOCK, Lane, MOST_LANES};

/// As [`transpose`]; single precision is widened on the way.
#[inline(always)]
pub(super) fn columns<X: Lane>(numbers: Numbers<'_>, length: usize, blocks: &[usize; MOST_LANES], out: &mut [X]) {
    let singles = match numbers {
        Numbers::Double(x) => return transpose(x, length, blocks, out),
        Numbers::Single(x) => x,
    };
    let mut doubles = [[0.0; BLOCK]; MOST_LANES];
    for (b, out) in out[..length].chunks_mut(BLOCK).enumerate() {
        for (doubles, block) in doubles[..X::LANES].iter_mut().zip(blocks) {
            let singles = &singles[block * length + BLOCK * b..(block + 1) * length];
            if let Some(singles) = singles.first_chunk::<BLOCK>() {
                // Of known length: one instruction.
                for l in 0..BLOCK {
                    doubles[l] = f64::from(singles[l]);
                }
            } else {
                doubles.iter_mut().zip(singles).for_each(|(double, single)| *double = f64::from(*single));
            }
        }
        let rows = doubles.each_ref().map(<[f64; BLOCK]>::as_slice);
        if let Some(whole) = out.first_chunk_mut::<BLOCK>() {
            X::load_columns(&rows[..X::LANES], 0, whole);
        } else {
            X::load_columns(&rows[..X::LANES], 0, out);
        }
    }
}

/// Number e of block `blocks[l]` goes to lane l of `out[e]`, for `length` numbers e.
#[inline(always)]
pub(super) fn transpose<X: Lane>(numbers: &[f64], length: usize, blocks: &[usize; MOST_LANES], out: &mut [X]) {
    let mut sources: [&[f64]; MOST_LANES] = [&[]; MOST_LANES];
    for (source, block) in sources[..X::LANES].iter_mut().zip(blocks) {
        *source = &numbers[block * length..(block + 1) * length];
    }
    let sources = &sources[..X::LANES];
    // Blocks of known length first: for them the compiler knows every instruction.
    let (blocks, rest) = out[..length].as_chunks_mut::<BLOCK>();
    for (b, block) in blocks.iter_mut().enumerate() {
        X::load_columns(sources, BLOCK * b, block);
    }
    if !rest.is_empty() {
        X::load_columns(sources, length - rest.len(), rest);
    }
}
