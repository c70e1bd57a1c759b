//! A tree of bodies joined by revolute and prismatic joints, and its forward dynamics.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use super::spatial::{Articulated, Force, Motion, Rigid, product, times, times_transposed};

/// How a body moves on its parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Joint {
    /// Turns about an axis.
    Revolute(Unit<Vector3<f64>>),
    /// Slides along an axis.
    Prismatic(Unit<Vector3<f64>>),
}

impl Joint {
    /// The joint's unit motion `S`, in the child's axes.
    fn motion(&self) -> Motion {
        match self {
            Joint::Revolute(axis) => Motion::new(axis.into_inner(), Vector3::zeros()),
            Joint::Prismatic(axis) => Motion::new(Vector3::zeros(), axis.into_inner()),
        }
    }
}

/// One body and the joint that carries it. With all joints at zero every body's axes are
/// parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Index of the parent: 0 is the base, the body after it is 1.
    pub parent: usize,
    pub joint: Joint,
    /// The joint's origin in the parent's axes, m; the body's own origin at zero travel.
    pub offset: Vector3<f64>,
    /// Inertia about the body's origin.
    pub inertia: Rigid,
}

/// Base and bodies; a parent stands before its children.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    pub base: Rigid,
    /// The others, each with its joint.
    pub bodies: Vec<Body>,
}

/// Known properties of one link at an instant. Vectors in the link's axes about its origin unless
/// said otherwise.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    /// Link to world.
    pub rotation: Matrix3<f64>,
    /// Origin in the world, m.
    pub position: Vector3<f64>,
    pub velocity: Motion,
    /// Force from outside; cleared by [`Tree::kinematics`].
    pub external: Force,
    to_parent: Matrix3<f64>,
    /// Whether `to_parent` is more than the identity.
    turned: bool,
    offset: Vector3<f64>,
    bias: Motion,
    inertia: Articulated,
    force: Force,
    response: Force,
    stiffness: f64,
    drive: f64,
    acceleration: Motion,
}

/// Scratch memory of one simulation: made once, no allocation later.
#[derive(Debug, Clone)]
pub struct Work {
    /// Base first.
    pub links: Vec<Link>,
    /// Joint accelerations (of `driven` joints: as given).
    pub acceleration: Vec<f64>,
    /// Joint torques or forces; of `driven` joints what the drive needs.
    pub torque: Vec<f64>,
    /// Joints that follow `acceleration` rather than `torque`.
    pub driven: Vec<bool>,
    /// Inertia of what turns with a joint through a gear, felt by the joint alone.
    pub armature: Vec<f64>,
}

impl Link {
    /// The parent's motion, seen from this link.
    fn carry(&self, parent: &Motion) -> Motion {
        let moved = Motion::new(parent.angular, parent.at(&self.offset));
        match self.turned {
            true => Motion::new(
                times_transposed(&self.to_parent, &moved.angular),
                times_transposed(&self.to_parent, &moved.linear),
            ),
            false => moved,
        }
    }

    /// Parameters to link axes.
    pub fn to_link(self, v: &Vector3<f64>) -> Vector3<f64> {
        times_transposed(&self.rotation, v)
    }

    /// Velocity in world axes of the link-fixed point at world position `p`.
    pub fn velocity_at(&self, p: &Vector3<f64>) -> Vector3<f64> {
        let r = self.to_link(&(p - self.position));
        times(&self.rotation, &self.velocity.at(&r))
    }

    /// Angular velocity in world axes.
    pub fn spin(&self) -> Vector3<f64> {
        times(&self.rotation, &self.velocity.angular)
    }

    /// Adds a force in world axes at a world position.
    pub fn push(&mut self, force: &Vector3<f64>, at: &Vector3<f64>) {
        let r = self.to_link(&(at - self.position));
        self.external += Force::at(self.to_link(force), &r);
    }

    /// Adds a moment in world axes.
    pub fn twist(&mut self, moment: &Vector3<f64>) {
        self.external += Force::moment(self.to_link(moment));
    }

    /// Acceleration of the link-fixed point at world position `p`, world axes, gravity not felt.
    pub fn acceleration_at(&self, p: &Vector3<f64>, gravity: &Vector3<f64>) -> Vector3<f64> {
        let r = self.to_link(&(p - self.position));
        let (w, a) = (&self.velocity.angular, &self.acceleration);
        // spatial to conventional acceleration: + w x v
        let point = a.linear + a.angular.cross(&r) + w.cross(&self.velocity.at(&r));
        times(&self.rotation, &point) + gravity
    }

    /// Angular acceleration in world axes.
    pub fn angular_acceleration(&self) -> Vector3<f64> {
        times(&self.rotation, &self.acceleration.angular)
    }
}

impl Tree {
    /// Scratch memory for this tree.
    pub fn work(&self) -> Work {
        let zero = Articulated { i: Matrix3::zeros(), h: Matrix3::zeros(), m: Matrix3::zeros() };
        let link = Link {
            rotation: Matrix3::identity(),
            position: Vector3::zeros(),
            velocity: Motion::default(),
            external: Force::default(),
            to_parent: Matrix3::identity(),
            turned: false,
            offset: Vector3::zeros(),
            bias: Motion::default(),
            inertia: zero,
            force: Force::default(),
            response: Force::default(),
            stiffness: 0.0,
            drive: 0.0,
            acceleration: Motion::default(),
        };
        let n = self.bodies.len();
        Work {
            links: vec![link; n + 1],
            acceleration: vec![0.0; n],
            torque: vec![0.0; n],
            driven: vec![false; n],
            armature: vec![0.0; n],
        }
    }

    /// The rigid inertia of link `i`.
    pub fn inertia(&self, i: usize) -> &Rigid {
        if i == 0 { &self.base } else { &self.bodies[i - 1].inertia }
    }

    /// Positions and velocities of all links: base pose (axes to world, origin in the world),
    /// base velocity in base axes, joint positions `q` and rates `qd`.
    pub fn kinematics(
        &self,
        rotation: &Matrix3<f64>,
        position: &Vector3<f64>,
        velocity: &Motion,
        q: &[f64],
        qd: &[f64],
        work: &mut Work,
    ) {
        let base = &mut work.links[0];
        base.rotation = *rotation;
        base.position = *position;
        base.velocity = *velocity;
        base.external = Force::default();
        for (j, body) in self.bodies.iter().enumerate() {
            // a parent stands before its children; a copy of a whole link takes longer than most of what follows
            let (before, rest) = work.links.split_at_mut(j + 1);
            let (parent, link) = (&before[body.parent], &mut rest[0]);
            link.offset = body.offset;
            link.turned = false;
            match &body.joint {
                // joints at rest, and wheels whose angle does not matter, spare the turning
                Joint::Revolute(axis) if q[j] != 0.0 => {
                    link.to_parent = Rotation3::from_axis_angle(axis, q[j]).into_inner();
                    link.turned = true;
                }
                Joint::Revolute(_) => {}
                Joint::Prismatic(axis) => link.offset += axis.into_inner() * q[j],
            }
            link.rotation = match link.turned {
                true => product(&parent.rotation, &link.to_parent),
                false => parent.rotation,
            };
            link.position = parent.position + times(&parent.rotation, &link.offset);
            let joint = body.joint.motion() * qd[j];
            let carried = link.carry(&parent.velocity);
            link.velocity = carried + joint;
            link.bias = link.velocity.cross(&joint);
            link.external = Force::default();
        }
    }

    /// Joint accelerations and the base's acceleration (rate of its velocity in base axes)
    /// after [`Tree::kinematics`], external forces and `work.torque`; `gravity` in world axes.
    ///
    /// Returns `None` when an inertia is singular (a massless base).
    pub fn dynamics(&self, gravity: &Vector3<f64>, work: &mut Work) -> Option<Motion> {
        for i in 0..work.links.len() {
            let inertia = self.inertia(i);
            let link = &mut work.links[i];
            link.inertia = inertia.into();
            let momentum = inertia.momentum(&link.velocity);
            link.force = link.velocity.cross_force(&momentum) - link.external;
        }
        for j in (0..self.bodies.len()).rev() {
            let body = &self.bodies[j];
            let s = body.joint.motion();
            let link = &mut work.links[j + 1];
            let (passed, force) = if work.driven[j] {
                let given = link.bias + s * work.acceleration[j];
                (link.inertia, link.force + link.inertia.apply(&given))
            } else {
                link.response = link.inertia.apply(&s);
                link.stiffness = s.dot(&link.response) + work.armature[j];
                link.drive = work.torque[j] - s.dot(&link.force);
                let rest = link.inertia.less(&link.response, link.stiffness);
                let push = link.response * (link.drive / link.stiffness);
                (rest, link.force + rest.apply(&link.bias) + push)
            };
            let r = link.offset;
            let (passed, force) = match link.turned {
                true => (passed.turned(&link.to_parent), force.turned(&link.to_parent)),
                false => (passed, force),
            };
            let parent = &mut work.links[body.parent];
            parent.inertia.add_child(&passed, &r);
            parent.force += Force { moment: force.moment + r.cross(&force.force), ..force };
        }
        // gravity as an upward acceleration of the base
        let base = &mut work.links[0];
        let felt = base.inertia.solve(&(base.force * -1.0))?;
        base.acceleration = felt;
        let own =
            Motion::new(felt.angular, felt.linear + times_transposed(&base.rotation, gravity));
        for (j, body) in self.bodies.iter().enumerate() {
            let parent = work.links[body.parent].acceleration;
            let s = body.joint.motion();
            let link = &mut work.links[j + 1];
            let carried = link.carry(&parent) + link.bias;
            if work.driven[j] {
                link.acceleration = carried + s * work.acceleration[j];
                let force = link.inertia.apply(&link.acceleration) + link.force;
                work.torque[j] = s.dot(&force);
            } else {
                let rate = (link.drive - carried.dot(&link.response)) / link.stiffness;
                work.acceleration[j] = rate;
                link.acceleration = carried + s * rate;
            }
        }
        Some(own)
    }

    /// Mass of all bodies, kg.
    pub fn mass(&self) -> f64 {
        self.base.mass + self.bodies.iter().map(|b| b.inertia.mass).sum::<f64>()
    }

    /// Centre of mass in the world, after [`Tree::kinematics`].
    pub fn centre(&self, work: &Work) -> Vector3<f64> {
        let sum: Vector3<f64> = (0..work.links.len())
            .map(|i| {
                let (link, inertia) = (&work.links[i], self.inertia(i));
                (link.position + link.rotation * inertia.centre) * inertia.mass
            })
            .sum();
        sum / self.mass()
    }

    /// Momentum and angular momentum about the world's origin, world axes.
    pub fn momentum(&self, work: &Work) -> Force {
        let mut total = Force::default();
        for i in 0..work.links.len() {
            let link = &work.links[i];
            let own = self.inertia(i).momentum(&link.velocity);
            let force = link.rotation * own.force;
            total +=
                Force { moment: link.rotation * own.moment + link.position.cross(&force), force };
        }
        total
    }

    /// Kinetic energy, J, after [`Tree::kinematics`].
    pub fn kinetic(&self, work: &Work) -> f64 {
        (0..work.links.len()).map(|i| self.inertia(i).kinetic(&work.links[i].velocity)).sum()
    }
}
