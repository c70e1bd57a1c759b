use super::*;

fn close(found: &[f64], expected: &[f64]) {
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= 1e-9 * e.abs(), "{found:?} is not {expected:?}");
    }
}

/// Independent numbers: dense n x n computation in numpy 2.4.6 (powers of `I - H_gg` by
/// eigenvalues, Satterthwaite from the n x n quadratic form with error covariance
/// `I + kappa 1_g 1_g'`, and a jackknife by refitting that agrees with CR3 to 1e-13).
#[test]
fn as_the_dense_computation() {
    let sizes = [3, 5, 7, 9, 4];
    let clusters: Vec<usize> =
        sizes.iter().enumerate().flat_map(|(g, &n)| std::iter::repeat_n(g, n)).collect();
    let i = |k: usize| k as f64;
    let jacobian = DMatrix::from_fn(clusters.len(), 3, |k, j| match j {
        0 => 1.0,
        1 => (1.7 * i(k)).sin() + 0.3 * i(clusters[k]),
        _ => (0.9 * i(k) * i(k)).cos(),
    });
    let b = [0.915593780490555, 1.9632871773012113, -0.5156175750810562];
    let mut residuals = Vec::new();
    let mut weights = Vec::new();
    for (k, &g) in clusters.iter().enumerate() {
        let x = jacobian.row(k);
        let error = 0.4 * (5.1 * i(g) + 1.0).sin() + 0.2 * (3.3 * i(k)).cos();
        let y = 1.0 + 2.0 * x[1] - 0.5 * x[2] + error;
        residuals.push(y - b[0] - b[1] * x[1] - b[2] * x[2]);
        weights.push(0.5 + 0.5 * (0.7 * i(k) + 0.2).sin().abs());
    }
    let scores = Scores {
        jacobian: &jacobian,
        residuals: &residuals,
        weights: &weights,
        psi_derivatives: None,
        clusters: &clusters,
    };
    let unit = |j: usize| DVector::from_fn(3, |k, _| f64::from(j == k));
    let dofs = |v: &ClusterCovariance, kappa: f64| -> Vec<f64> {
        let Some(shape) = &v.shape else { panic!("no shape") };
        (0..3).map(|j| shape.dof_with(&unit(j), kappa)).collect()
    };

    let Ok(cr2) = sandwich_with(&scores, Correction::Cr2) else { panic!("CR2") };
    #[rustfmt::skip]
    close(cr2.covariance.as_slice(), &[
        0.020180362239063457, -0.00688725871026998, -0.001900184961400207,
        -0.00688725871026998, 0.004138445897246707, -0.002242192520342554,
        -0.001900184961400207, -0.002242192520342554, 0.00630860792674272,
    ]);
    close(&dofs(&cr2, 0.0), &[2.9674756099148327, 3.458865072109168, 3.90881435691914]);
    close(&dofs(&cr2, 2.0), &[2.6214164384524166, 2.921502128878048, 3.3007959946416237]);

    let Ok(cr3) = sandwich_with(&scores, Correction::Cr3) else { panic!("CR3") };
    #[rustfmt::skip]
    close(cr3.covariance.as_slice(), &[
        0.02580072645858008, -0.008472522145015036, -0.0026005270741064385,
        -0.008472522145015036, 0.005394309525434527, -0.0033216661106374714,
        -0.0026005270741064385, -0.0033216661106374714, 0.008646895581142375,
    ]);
    close(&dofs(&cr3, 0.0), &[2.6524420198947483, 3.178715104354681, 3.911009378319625]);
    close(&dofs(&cr3, 2.0), &[2.427870828116794, 2.579421573957035, 3.26822688633366]);

    let (se, dof) = cr2.contrast(&[0.0, 1.0, 0.0]);
    close(&[se, dof], &[cr2.covariance[(1, 1)].sqrt(), cr2.dof[1]]);
}

#[test]
fn what_one_manoeuvre_alone_determines_is_not_believed() {
    // the second column is zero outside the last manoeuvre
    let clusters = [0, 0, 1, 1, 2, 2, 3, 3];
    let jacobian = DMatrix::from_fn(8, 2, |k, j| match (j, k) {
        (0, _) => 1.0,
        (_, 7) => 1.0,
        _ => 0.0,
    });
    let residuals = [0.1, -0.2, 0.3, 0.1, -0.1, -0.3, 0.1, 0.0];
    let scores = Scores {
        jacobian: &jacobian,
        residuals: &residuals,
        weights: &[1.0; 8],
        psi_derivatives: None,
        clusters: &clusters,
    };
    let Ok(v) = sandwich(&scores) else { panic!("covariance") };
    assert!(v.dof[0] > 1.5);
    assert_eq!(v.dof[1], 0.0);
    assert_eq!(v.contrast(&[0.5, -1.0]).1, 0.0);
}

#[test]
fn says_what_is_wrong() {
    let jacobian = DMatrix::from_element(4, 1, 1.0);
    let base = Scores {
        jacobian: &jacobian,
        residuals: &[0.1; 4],
        weights: &[1.0; 4],
        psi_derivatives: None,
        clusters: &[0, 0, 0, 0],
    };
    assert_eq!(sandwich(&base).err(), Some(Error::TooFew(1)));
    let short = Scores { weights: &[1.0; 3], ..base };
    let expected = Error::Length { what: "weights", found: 3, expected: 4 };
    assert_eq!(sandwich(&short).err(), Some(expected));
    let zero = DMatrix::zeros(4, 1);
    let flat = Scores { jacobian: &zero, clusters: &[0, 0, 1, 1], ..base };
    assert_eq!(sandwich(&flat).err(), Some(Error::Singular));
}
