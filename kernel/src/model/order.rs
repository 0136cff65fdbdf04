//! The order in which Kratos loops over sub model parts.
//!
//! Kratos keeps them in a hash table of the GNU C++ library (`unordered_map` with text keys), so
//! its loops follow neither the file nor the alphabet, and ids that are handed out in such a loop
//! depend on it. The ingredients: a 64-bit hash of the MurmurHash2 family, bucket counts from a
//! list of primes, and one linked list through all buckets.

/// Bucket counts; the table grows to the next one before the names would exceed the present one.
/// (The library's list goes on; a model has no million of sub model parts.)
const BUCKETS: [u64; 17] =
    [13, 29, 59, 127, 257, 541, 1109, 2357, 5087, 10273, 20753, 42043, 85229, 172933, 351061, 712697, 1447153];

/// Positions of `names` (distinct, in the order of the file) in the order of Kratos's loops.
///
/// ```
/// use bia_kernel::model::kratos_order;
/// assert_eq!(kratos_order(&["first", "second"]), [1, 0]);
/// ```
pub fn kratos_order(names: &[&str]) -> Vec<usize> {
    let hashes: Vec<u64> = names.iter().map(|name| hash(name.as_bytes())).collect();
    let mut counts = BUCKETS.into_iter();
    let mut buckets = 0;
    let mut order = Vec::with_capacity(names.len());
    for name in 0..names.len() {
        if name as u64 + 1 > buckets
            && let Some(larger) = counts.next()
        {
            buckets = larger;
            let before = std::mem::replace(&mut order, Vec::with_capacity(names.len()));
            before.into_iter().for_each(|old| insert(&mut order, old, &hashes, buckets));
        }
        insert(&mut order, name, &hashes, buckets);
    }
    order
}

/// A name goes before the first one of its bucket, or to the very front when there is none.
fn insert(order: &mut Vec<usize>, name: usize, hashes: &[u64], buckets: u64) {
    let bucket = hashes[name] % buckets;
    let first = order.iter().position(|&other| hashes[other] % buckets == bucket);
    order.insert(first.unwrap_or(0), name);
}

/// The hash of the GNU C++ library for texts on 64-bit machines (MurmurHash2 by A. Appleby with a
/// fixed seed).
fn hash(bytes: &[u8]) -> u64 {
    const SEED: u64 = 0xc70f_6907;
    const FACTOR: u64 = 0xc6a4_a793_5bd1_e995;
    let mix = |value: u64| value ^ (value >> 47);
    let mut hash = SEED ^ (bytes.len() as u64).wrapping_mul(FACTOR);
    let mut words = bytes.chunks_exact(8);
    for word in &mut words {
        let word = mix(little_endian(word).wrapping_mul(FACTOR)).wrapping_mul(FACTOR);
        hash = (hash ^ word).wrapping_mul(FACTOR);
    }
    let rest = words.remainder();
    if !rest.is_empty() {
        hash = (hash ^ little_endian(rest)).wrapping_mul(FACTOR);
    }
    mix(mix(hash).wrapping_mul(FACTOR))
}

fn little_endian(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u64::from(byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `std::hash<std::string>` of gcc 12.2.0 (Debian, x86-64), printed by a C++ program.
    #[test]
    fn hashes_are_those_of_gcc() {
        assert_eq!(hash(b""), 0x553e_9390_1e46_2a6e);
        assert_eq!(hash(b"a"), 0x454d_dee4_88c1_ed6b);
        assert_eq!(hash(b"12345678"), 0x8c5b_90a3_3a04_dca5);
        assert_eq!(hash(b"a longer name of 25 bytes"), 0x0e04_17ad_eb5d_af3f);
    }

    #[test]
    fn one_and_two_names() {
        assert_eq!(kratos_order(&[]), [0; 0]);
        assert_eq!(kratos_order(&["Parts_body"]), [0]);
        // In different buckets the later name comes first; so it does in the same one.
        assert_eq!(kratos_order(&["Parts_a", "Parts_b"]), [1, 0]);
    }

    /// Up to 13 names without a shared bucket are simply reversed; the fourteenth rebuilds the
    /// table from that list, which reverses it again, and goes to the front of it.
    #[test]
    fn the_fourteenth_name_rebuilds_the_table() {
        let mut names: Vec<String> = Vec::new();
        let (mut small, mut large) = (std::collections::HashSet::new(), std::collections::HashSet::new());
        for candidate in (0..).map(|i| format!("part{i}")) {
            let hash = hash(candidate.as_bytes());
            let alone = names.len() == 13 || !small.contains(&(hash % 13));
            if alone && large.insert(hash % 29) {
                small.insert(hash % 13);
                names.push(candidate);
            }
            if names.len() == 14 {
                break;
            }
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert_eq!(kratos_order(&names[..13]), (0..13).rev().collect::<Vec<_>>());
        let mut expected = vec![13];
        expected.extend(0..13);
        assert_eq!(kratos_order(&names), expected);
    }

    /// Orders that a C++ program printed, compiled by gcc 12.2.0 (Debian, x86-64): name sets
    /// `p<set>_<i>` of the given sizes, inserted by rising `i`.
    #[test]
    fn orders_are_those_of_gcc() {
        for (set, expected) in GCC_ORDERS.iter().enumerate() {
            let names: Vec<String> = (0..expected.len()).map(|i| format!("p{set}_{i}")).collect();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            assert_eq!(kratos_order(&names), *expected, "set {set}");
        }
    }

    const GCC_ORDERS: [&[usize]; 5] = [
        &[2, 1, 0],
        &[6, 5, 4, 3, 7, 2, 1, 0],
        &[10, 9, 7, 6, 12, 4, 3, 2, 8, 5, 1, 11, 0],
        &[19, 17, 14, 15, 13, 0, 12, 1, 4, 2, 3, 18, 5, 16, 6, 9, 10, 7, 8, 11],
        &[
            39, 38, 36, 35, 31, 9, 8, 16, 6, 33, 32, 5, 0, 30, 4, 3, 7, 1, 23, 2, 34, 17, 12, 13, 10, 21, 14, 11, 18,
            15, 19, 37, 29, 24, 20, 28, 22, 25, 26, 27,
        ],
    ];
}
