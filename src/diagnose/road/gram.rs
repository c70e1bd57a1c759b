//! Products of the columns of a linearisation with each other, channel by channel. Weights of a robust fit are one for
//! most blocks: once the products are known under some weights, those under others are a correction by the few blocks
//! whose weight is another.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::residuals::Blocks;

/// Columns whose products are made together: those with columns before them are known by symmetry.
const PANEL: usize = 24;

/// A block that counts, and its weight.
pub(crate) type Row = (usize, f64);

/// Products of columns under weights.
#[derive(Debug, Clone)]
pub(crate) struct Gram {
    /// `[channel][block]`, nil where a block does not count.
    weights: Blocks,
    channels: [Channel; 8],
}

/// Products in one channel.
#[derive(Debug, Clone)]
struct Channel {
    /// The columns that enter it: most parameters enter few channels.
    inside: Vec<usize>,
    products: DMatrix<f64>,
}

impl Gram {
    /// That of all columns.
    pub(crate) fn of(columns: &[Arc<Blocks>], weights: &Blocks) -> Self {
        let channels = std::array::from_fn(|c| {
            let inside = entering(columns, c);
            let products = products(columns, c, &inside, &counted(&weights[c]));
            Channel { inside, products }
        });
        Gram { weights: weights.clone(), channels }
    }

    /// That of some of the columns, which are given in their order.
    pub(crate) fn only(&self, kept: &[usize]) -> Self {
        let channels = std::array::from_fn(|c| {
            let Channel { inside, products } = &self.channels[c];
            let place = |column: &usize| inside.iter().position(|i| i == column);
            let (inside, places): (Vec<usize>, Vec<usize>) = kept
                .iter()
                .enumerate()
                .filter_map(|(k, column)| place(column).map(|place| (k, place)))
                .unzip();
            let products = DMatrix::from_fn(inside.len(), inside.len(), |k, l| {
                products[(places[k], places[l])]
            });
            Channel { inside, products }
        });
        Gram { weights: self.weights.clone(), channels }
    }

    /// The products of the first `count` columns under any weights, over the variances of the channels.
    pub(crate) fn under(
        &self,
        weights: &Blocks,
        columns: &[Arc<Blocks>],
        sigma: &[f64; 8],
        count: usize,
    ) -> DMatrix<f64> {
        let mut out = DMatrix::zeros(count, count);
        for (c, channel) in self.channels.iter().enumerate() {
            let own = channel.inside.iter().take_while(|i| **i < count).count();
            let inside = &channel.inside[..own];
            let known = self.weights[c].iter().zip(&weights[c]).enumerate();
            let changed: Vec<Row> = known
                .filter(|(_, (before, now))| before != now)
                .map(|(b, (before, now))| (b, now - before))
                .collect();
            let rows = counted(&weights[c]);
            let mut sum = match 2 * changed.len() > rows.len() {
                true => products(columns, c, inside, &rows),
                false => {
                    let change = products(columns, c, inside, &changed);
                    change + channel.products.view((0, 0), (own, own))
                }
            };
            sum /= sigma[c] * sigma[c];
            for (k, &i) in inside.iter().enumerate() {
                for (l, &j) in inside.iter().enumerate() {
                    out[(j, i)] += sum[(l, k)];
                }
            }
        }
        out
    }
}

/// The blocks with a weight.
pub(crate) fn counted(weights: &[f64]) -> Vec<Row> {
    weights.iter().copied().enumerate().filter(|(_, weight)| *weight != 0.0).collect()
}

/// The columns that are not nil in a channel.
pub(crate) fn entering(columns: &[Arc<Blocks>], c: usize) -> Vec<usize> {
    (0..columns.len()).filter(|&i| columns[i][c].iter().any(|x| *x != 0.0)).collect()
}

/// Some columns of a channel at some blocks: a row each.
pub(crate) fn gathered(
    columns: &[Arc<Blocks>],
    c: usize,
    inside: &[usize],
    rows: &[Row],
) -> DMatrix<f64> {
    let values = inside.iter().flat_map(|&i| {
        let column = &columns[i][c];
        rows.iter().map(move |(b, _)| column[*b])
    });
    DMatrix::from_iterator(rows.len(), inside.len(), values)
}

fn products(columns: &[Arc<Blocks>], c: usize, inside: &[usize], rows: &[Row]) -> DMatrix<f64> {
    let n = inside.len();
    let mut out = DMatrix::zeros(n, n);
    if rows.is_empty() {
        return out;
    }
    let mut right = gathered(columns, c, inside, rows);
    let left = right.transpose();
    for mut column in right.column_iter_mut() {
        column.iter_mut().zip(rows).for_each(|(x, (_, weight))| *x *= weight);
    }
    for start in (0..n).step_by(PANEL) {
        let width = PANEL.min(n - start);
        let own = left.rows(start, n - start) * right.columns(start, width);
        out.view_mut((start, start), (n - start, width)).copy_from(&own);
    }
    out.fill_upper_triangle_with_lower_triangle();
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    fn sum(columns: &[Arc<Blocks>], weights: &Blocks, sigma: &[f64; 8], i: usize, j: usize) -> f64 {
        let of = |c: usize, b: usize| columns[i][c][b] * columns[j][c][b] * weights[c][b];
        let channel = |c: usize| (0..50).map(|b| of(c, b)).sum::<f64>() / sigma[c] / sigma[c];
        (0..8).map(channel).sum()
    }

    #[test]
    fn products_under_other_weights_are_sums_over_blocks() {
        let mut random = Random::new(1, "gram");
        let mut column = |enters: bool| -> Arc<Blocks> {
            let mut value = || if enters { random.normal() } else { 0.0 };
            Arc::new(std::array::from_fn(|c| {
                (0..50).map(|_| if c == 3 { 0.0 } else { value() }).collect()
            }))
        };
        let columns: Vec<Arc<Blocks>> = (0..60).map(|k| column(k % 7 != 2)).collect();
        let sigma = [0.1, 1.0, 2.0, 0.5, 3.0, 1.0, 1.0, 0.2];
        let ones: Blocks = std::array::from_fn(|_| vec![1.0; 50]);
        // a few blocks less, hardly any, most of them
        for (every, weight) in [(9, 0.3), (1, 0.0), (2, 0.5)] {
            let mut weights = ones.clone();
            weights.iter_mut().flatten().step_by(every).for_each(|w| *w = weight);
            for gram in [Gram::of(&columns, &ones), Gram::of(&columns, &weights)] {
                let kept: Vec<usize> = (0..40).chain([55]).collect();
                let some: Vec<Arc<Blocks>> = kept.iter().map(|k| columns[*k].clone()).collect();
                let (all, part) = (
                    gram.under(&weights, &columns, &sigma, 57),
                    gram.only(&kept).under(&weights, &some, &sigma, 41),
                );
                for (i, j) in [(0, 0), (3, 30), (56, 55), (30, 3), (2, 5)] {
                    let truth = sum(&columns, &weights, &sigma, i, j);
                    assert!((all[(i, j)] - truth).abs() < 1e-9 * (1.0 + truth.abs()), "{i} {j}");
                }
                let truth = sum(&columns, &weights, &sigma, 55, 4);
                assert!((part[(40, 4)] - truth).abs() < 1e-9 * (1.0 + truth.abs()));
            }
        }
    }
}
