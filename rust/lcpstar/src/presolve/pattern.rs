//! Where A has entries, and which of them are negative: sets of indices in machine words, row by row.

use crate::problem::Lcp;
use multiversion::multiversion;

/// Indices in a word.
const WORD: usize = 64;

/// The pattern of A.
#[derive(Clone, Debug)]
pub struct Pattern {
    n: usize,
    words: usize,
    nonzero: Vec<u64>,
    negative: Vec<u64>,
    /// The rows of A', when asked for.
    transposed: Vec<u64>,
}

impl Pattern {
    /// O(n^2), one vectorised pass.
    pub fn of(lcp: &Lcp) -> Self {
        let n = lcp.n();
        let words = n.div_ceil(WORD);
        let (mut nonzero, mut negative) = (vec![0; n * words], vec![0; n * words]);
        read(n, lcp.a(), words, &mut nonzero, &mut negative);
        Self { n, words, nonzero, negative, transposed: vec![] }
    }

    /// Order.
    pub fn n(&self) -> usize {
        self.n
    }

    /// The empty set.
    pub fn empty(&self) -> Set {
        Set(vec![0; self.words])
    }

    /// The set of these indices.
    pub fn set_of(&self, indices: impl IntoIterator<Item = usize>) -> Set {
        let mut set = self.empty();
        indices.into_iter().for_each(|i| _ = set.insert(i));
        set
    }

    /// Columns with an entry in row i.
    pub fn row(&self, i: usize) -> &[u64] {
        &self.nonzero[i * self.words..(i + 1) * self.words]
    }

    /// Columns with a negative entry in row i.
    pub fn negative(&self, i: usize) -> &[u64] {
        &self.negative[i * self.words..(i + 1) * self.words]
    }

    /// Rows with an entry in column j, once [`Self::transpose`] was called.
    pub fn column(&self, j: usize) -> &[u64] {
        &self.transposed[j * self.words..(j + 1) * self.words]
    }

    /// Makes [`Self::column`] possible. O(n^2 / 8), a tile of 64 rows and columns at a time.
    pub fn transpose(&mut self) {
        if !self.transposed.is_empty() {
            return;
        }
        self.transposed = vec![0; self.n * self.words];
        let mut tile = [0; WORD];
        for below in 0..self.words {
            for across in 0..self.words {
                let rows = self.nonzero.chunks_exact(self.words).skip(WORD * below);
                tile.fill(0);
                tile.iter_mut().zip(rows).for_each(|(word, row)| *word = row[across]);
                transpose_tile(&mut tile);
                let columns = self.transposed.chunks_exact_mut(self.words).skip(WORD * across);
                columns.zip(&tile).for_each(|(column, word)| column[below] = *word);
            }
        }
    }
}

/// Bit j of word i and bit i of word j change places: quarters of the tile are exchanged, then quarters of its quarters.
/// [War12, sec. 7-3]
fn transpose_tile(tile: &mut [u64; WORD]) {
    let (mut half, mut low) = (WORD / 2, u64::MAX >> (WORD / 2));
    while half > 0 {
        for i in (0..WORD).filter(|i| i & half == 0) {
            let change = (tile[i] >> half ^ tile[i + half]) & low;
            tile[i] ^= change << half;
            tile[i + half] ^= change;
        }
        half /= 2;
        low ^= low << half;
    }
}

/// A set of indices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Set(pub Vec<u64>);

impl Set {
    /// Whether it holds i.
    pub fn has(&self, i: usize) -> bool {
        self.0[i / WORD] >> (i % WORD) & 1 == 1
    }

    /// Puts i in; `false` when it was there.
    pub fn insert(&mut self, i: usize) -> bool {
        let old = self.0[i / WORD];
        self.0[i / WORD] |= 1 << (i % WORD);
        old != self.0[i / WORD]
    }

    /// All others.
    pub fn complement(&self) -> Set {
        Set(self.0.iter().map(|word| !word).collect())
    }

    /// Takes i out.
    pub fn remove(&mut self, i: usize) {
        self.0[i / WORD] &= !(1 << (i % WORD));
    }
}

/// The members of a set, increasing.
pub fn indices(set: &[u64]) -> impl Iterator<Item = usize> + '_ {
    set.iter().enumerate().flat_map(|(k, &word)| {
        std::iter::successors((word != 0).then_some(word), |rest| Some(rest & (rest - 1)).filter(|&rest| rest != 0))
            .map(move |rest| k * WORD + rest.trailing_zeros() as usize)
    })
}

/// The least member of both sets from `from` on.
pub fn next_common(a: &[u64], b: &[u64], from: usize) -> Option<usize> {
    let mut k = from / WORD;
    let mut mask = u64::MAX << (from % WORD);
    while k < a.len() {
        let word = a[k] & b[k] & mask;
        if word != 0 {
            return Some(k * WORD + word.trailing_zeros() as usize);
        }
        (k, mask) = (k + 1, u64::MAX);
    }
    None
}

/// Whether the sets have a common member.
pub fn meet(a: &[u64], b: &[u64]) -> bool {
    a.iter().zip(b).any(|(a, b)| a & b != 0)
}

/// A bit for each entry, eight entries side by side.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2+fma", "aarch64+neon"))]
fn read(n: usize, a: &[f64], words: usize, nonzero: &mut [u64], negative: &mut [u64]) {
    const LANES: usize = 8;
    for i in 0..n {
        for k in 0..words {
            let entries = &a[i * n + k * WORD..i * n + ((k + 1) * WORD).min(n)];
            let mut bits = [1_u64, 2, 4, 8, 16, 32, 64, 128];
            let (mut all, mut below) = ([0_u64; LANES], [0_u64; LANES]);
            let chunks = entries.chunks_exact(LANES);
            let tail = chunks.remainder();
            let done = entries.len() - tail.len();
            for x in chunks {
                for l in 0..LANES {
                    all[l] |= if x[l] != 0.0 { bits[l] } else { 0 };
                    below[l] |= if x[l] < 0.0 { bits[l] } else { 0 };
                }
                for bit in &mut bits {
                    *bit <<= LANES;
                }
            }
            let (mut all, mut below) = (all.iter().fold(0, |s, x| s | x), below.iter().fold(0, |s, x| s | x));
            for (l, &x) in tail.iter().enumerate() {
                all |= u64::from(x != 0.0) << (done + l);
                below |= u64::from(x < 0.0) << (done + l);
            }
            (nonzero[i * words + k], negative[i * words + k]) = (all, below);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_entry_is_where_it_belongs() {
        for n in [1, 7, 63, 64, 65, 130] {
            let entry = |i: usize, j: usize| f64::from((i * 31 + j * 17) as i32 % 5 - 1);
            let a: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            let mut pattern = Pattern::of(&Lcp::new(n, a, vec![0.0; n]).expect("valid"));
            pattern.transpose();
            let everything = vec![u64::MAX; n.div_ceil(WORD)];
            for i in 0..n {
                let expected: Vec<usize> = (0..n).filter(|&j| entry(i, j) != 0.0).collect();
                assert_eq!(indices(pattern.row(i)).collect::<Vec<_>>(), expected);
                assert_eq!(next_common(pattern.row(i), &everything, n / 2), expected.into_iter().find(|&j| j >= n / 2));
                let negative: Vec<usize> = (0..n).filter(|&j| entry(i, j) < 0.0).collect();
                assert_eq!(indices(pattern.negative(i)).collect::<Vec<_>>(), negative);
                let column: Vec<usize> = (0..n).filter(|&j| entry(j, i) != 0.0).collect();
                assert_eq!(indices(pattern.column(i)).collect::<Vec<_>>(), column);
            }
        }
    }

    #[test]
    fn sets_grow_once() {
        let mut set = Set(vec![0; 2]);
        assert!(set.insert(64) && !set.insert(64) && set.has(64) && !set.has(0));
        assert!(meet(&set.0, &[0, 1]) && !meet(&set.0, &[1, 0]));
    }
}
