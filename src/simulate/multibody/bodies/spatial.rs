//! Spatial vectors and inertias in Plücker coordinates, as blocks of 3.
//!
//! A motion vector is (angular, linear velocity of the body-fixed point at the origin), a force
//! vector (moment about the origin, force). Notation of Featherstone 2008, chapter 2.

use nalgebra::{Cholesky, Matrix3, Matrix6, Vector3, Vector6};

/// Cross-product matrix: `skew(a) b = a x b`.
pub(crate) fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// `m v`. Written out, as the next two, with the same order of sums: nalgebra's own goes through strided loops that are
/// not unrolled, a third of a simulation's time.
#[inline]
pub(crate) fn times(m: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let row = |r: usize| m[(r, 0)] * v.x + m[(r, 1)] * v.y + m[(r, 2)] * v.z;
    Vector3::new(row(0), row(1), row(2))
}

/// `m' v`.
#[inline]
pub(crate) fn times_transposed(m: &Matrix3<f64>, v: &Vector3<f64>) -> Vector3<f64> {
    let column = |c: usize| m[(0, c)] * v.x + m[(1, c)] * v.y + m[(2, c)] * v.z;
    Vector3::new(column(0), column(1), column(2))
}

/// `a b`.
#[inline]
pub(crate) fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|r, c| a[(r, 0)] * b[(0, c)] + a[(r, 1)] * b[(1, c)] + a[(r, 2)] * b[(2, c)])
}

/// `a b'`.
#[inline]
fn outer(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|r, c| a[r] * b[c])
}

/// Spatial motion: velocity or acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Angular part.
    pub angular: Vector3<f64>,
    /// Linear part, of the point at the origin.
    pub linear: Vector3<f64>,
}

/// Spatial force.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Force {
    /// Moment about the origin.
    pub moment: Vector3<f64>,
    pub force: Vector3<f64>,
}

impl Motion {
    /// From both parts.
    pub fn new(angular: Vector3<f64>, linear: Vector3<f64>) -> Self {
        Motion { angular, linear }
    }

    /// Velocity of the body-fixed point at `r`.
    pub fn at(&self, r: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(r)
    }

    /// `self x other` for motions.
    pub fn cross(&self, other: &Motion) -> Motion {
        Motion {
            angular: self.angular.cross(&other.angular),
            linear: self.angular.cross(&other.linear) + self.linear.cross(&other.angular),
        }
    }

    /// `self x* force`.
    pub fn cross_force(&self, f: &Force) -> Force {
        Force {
            moment: self.angular.cross(&f.moment) + self.linear.cross(&f.force),
            force: self.angular.cross(&f.force),
        }
    }

    /// Power of a force.
    pub fn dot(&self, f: &Force) -> f64 {
        self.angular.dot(&f.moment) + self.linear.dot(&f.force)
    }
}

impl std::ops::Add for Motion {
    type Output = Motion;
    fn add(self, o: Motion) -> Motion {
        Motion { angular: self.angular + o.angular, linear: self.linear + o.linear }
    }
}

impl std::ops::Mul<f64> for Motion {
    type Output = Motion;
    fn mul(self, k: f64) -> Motion {
        Motion { angular: self.angular * k, linear: self.linear * k }
    }
}

impl Force {
    /// A force that acts at the point `r`.
    pub fn at(force: Vector3<f64>, r: &Vector3<f64>) -> Self {
        Force { moment: r.cross(&force), force }
    }

    pub fn moment(moment: Vector3<f64>) -> Self {
        Force { moment, force: Vector3::zeros() }
    }
}

impl Force {
    /// In axes that `rotation` leads to.
    pub fn turned(&self, rotation: &Matrix3<f64>) -> Self {
        Force { moment: times(rotation, &self.moment), force: times(rotation, &self.force) }
    }
}

impl std::ops::Add for Force {
    type Output = Force;
    fn add(self, o: Force) -> Force {
        Force { moment: self.moment + o.moment, force: self.force + o.force }
    }
}

impl std::ops::AddAssign for Force {
    fn add_assign(&mut self, o: Force) {
        self.moment += o.moment;
        self.force += o.force;
    }
}

impl std::ops::Sub for Force {
    type Output = Force;
    fn sub(self, o: Force) -> Force {
        Force { moment: self.moment - o.moment, force: self.force - o.force }
    }
}

impl std::ops::Mul<f64> for Force {
    type Output = Force;
    fn mul(self, k: f64) -> Force {
        Force { moment: self.moment * k, force: self.force * k }
    }
}

/// Inertia of one rigid body about its frame's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub centre: Vector3<f64>,
    /// About the origin, kg m².
    pub about_origin: Matrix3<f64>,
}

impl Rigid {
    /// From the inertia about the centre of mass.
    pub fn new(mass: f64, centre: Vector3<f64>, about_centre: Matrix3<f64>) -> Self {
        let c = skew(&centre);
        Rigid { mass, centre, about_origin: about_centre - c * c * mass }
    }

    /// Momentum of a motion.
    pub fn momentum(&self, v: &Motion) -> Force {
        Force {
            moment: times(&self.about_origin, &v.angular)
                + self.centre.cross(&v.linear) * self.mass,
            force: v.at(&self.centre) * self.mass,
        }
    }

    /// Kinetic energy of a motion, J.
    pub fn kinetic(&self, v: &Motion) -> f64 {
        0.5 * v.dot(&self.momentum(v))
    }
}

/// Articulated inertia: moment `= i w + h v`, force `= h' w + m v`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Articulated {
    /// Angular block, symmetric.
    pub i: Matrix3<f64>,
    /// Coupling block.
    pub h: Matrix3<f64>,
    /// Linear block, symmetric.
    pub m: Matrix3<f64>,
}

impl From<&Rigid> for Articulated {
    fn from(r: &Rigid) -> Self {
        Articulated {
            i: r.about_origin,
            h: skew(&r.centre) * r.mass,
            m: Matrix3::from_diagonal_element(r.mass),
        }
    }
}

impl Articulated {
    /// Force that gives an acceleration.
    pub(crate) fn apply(&self, a: &Motion) -> Force {
        Force {
            moment: times(&self.i, &a.angular) + times(&self.h, &a.linear),
            force: times_transposed(&self.h, &a.angular) + times(&self.m, &a.linear),
        }
    }

    /// `self - u u' / d`: the articulated inertia beyond a free joint.
    pub(crate) fn less(&self, u: &Force, d: f64) -> Self {
        let k = 1.0 / d;
        Articulated {
            i: self.i - outer(&u.moment, &u.moment) * k,
            h: self.h - outer(&u.moment, &u.force) * k,
            m: self.m - outer(&u.force, &u.force) * k,
        }
    }

    /// In axes that `rotation` leads to.
    pub(crate) fn turned(&self, rotation: &Matrix3<f64>) -> Self {
        let back = rotation.transpose();
        let turn = |x: &Matrix3<f64>| product(&product(rotation, x), &back);
        Articulated { i: turn(&self.i), h: turn(&self.h), m: turn(&self.m) }
    }

    /// Adds a child's inertia in parallel axes, its origin at `r`.
    pub(crate) fn add_child(&mut self, child: &Articulated, r: &Vector3<f64>) {
        let rx = skew(r);
        let rm = product(&rx, &child.m);
        let hr = product(&child.h, &rx);
        self.i += child.i - hr - hr.transpose() - product(&rm, &rx);
        self.h += child.h + rm;
        self.m += child.m;
    }

    /// Acceleration under a force; `None` when the inertia is singular.
    pub(crate) fn solve(&self, f: &Force) -> Option<Motion> {
        let mut a = Matrix6::zeros();
        a.fixed_view_mut::<3, 3>(0, 0).copy_from(&self.i);
        a.fixed_view_mut::<3, 3>(0, 3).copy_from(&self.h);
        a.fixed_view_mut::<3, 3>(3, 0).copy_from(&self.h.transpose());
        a.fixed_view_mut::<3, 3>(3, 3).copy_from(&self.m);
        let b = Vector6::new(f.moment.x, f.moment.y, f.moment.z, f.force.x, f.force.y, f.force.z);
        let x = Cholesky::new(a)?.solve(&b);
        Some(Motion::new(Vector3::new(x[0], x[1], x[2]), Vector3::new(x[3], x[4], x[5])))
    }
}
