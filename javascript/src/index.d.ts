// Types of Thrum in JavaScript. Quantities are SI; r is a model's rank, n its number of vertices.
// SPDX-License-Identifier: Apache-2.0

/** Three numbers. */
export type Vector = ArrayLike<number>;

export type Integrator =
  | 'imexv' | 'newmark' | 'verlet' | 'midpoint' | 'energy' | 'fox-goodwin'
  | 'backward-euler' | 'semi-implicit-euler' | 'rk4' | 'manifold';

/** A call failed: `status` is that of the C library (thrum/status.h), the message is for people. */
export class ThrumError extends Error {
  readonly status: number;
}

/** What a call that did its work may say besides; the smaller, the more notable. */
export const Status: {
  readonly OK: 0;
  /** The energy grew beyond what the start and the loads explain. */
  readonly ENERGY_GREW: 1;
  /** A step needed a fallback. */
  readonly FELL_BACK: 2;
  /** The integrator has switched its scheme. */
  readonly SWITCHED: 3;
};

interface Freed {
  /** Frees it at once; otherwise it goes with the garbage. What is built on it keeps what it needs. */
  free(): void;
}

/** Vertices of a model: one of the three; none: all of the body. */
export interface Place {
  /** 0-based. */
  vertices?: Iterable<number>;
  vertex?: number;
  /** Name of a group of the model. */
  group?: string;
}

export interface Equilibrium {
  /** Coordinates, r. */
  q: Float64Array;
  /** Factor of the load that q balances. */
  factor: number;
  /** Strain energy [J]. */
  energy: number;
  /** Least eigenvalue of the tangent stiffness [1/s^2]; below 0: unstable. */
  least: number;
  /** Factor at which the path lost its stability first; NaN: it did not. */
  critical: number;
  stable: boolean;
}

/** A reduced model; states, scenes and models made from it keep its memory. Arrays are copies. */
export class Model implements Freed {
  private constructor();
  free(): void;
  /** Number of coordinates r. */
  readonly rank: number;
  /** Number of coordinates that show the body: r, but for a condensed model. */
  readonly shown: number;
  /** Coordinates of a model that was precomputed condensed, which `condense` makes steppable; else 0. */
  readonly masters: number;
  readonly vertexCount: number;
  readonly tetCount: number;
  /** Squared angular frequencies [1/s^2], r. */
  readonly omega2: Float64Array;
  /** Frequencies at rest [Hz], r. */
  readonly frequencies: Float64Array;
  /** Rest positions [m], 3 n; undefined without a mesh, as are the next four. */
  readonly vertices: Float64Array | undefined;
  /** 0-based corners, four a tetrahedron. */
  readonly tets: Int32Array | undefined;
  /** n: bit 0, 1, 2 is set where x, y, z is held. */
  readonly fixed: Uint8Array | undefined;
  /** Young's modulus [Pa], Poisson's ratio, density [kg/m^3], for each region. */
  readonly material: Float64Array | undefined;
  /** The law of each region: stvk, corotational or neo-hookean; one where they are not told apart. */
  readonly laws: string[];
  /** U [kg^-1/2], 3 n rows of `shown` numbers. */
  readonly basis: Float64Array | undefined;
  /** Named groups of 0-based vertices. */
  readonly groups: Record<string, Int32Array>;
  /** What precompute noted about the model. */
  readonly meta: Record<string, unknown>;
  group(name: string): Int32Array;
  /** Steps the lowest `rank` coordinates while all others follow at rest, as `condense` does; of r, this model. No
   * coordinate is cut off, for a body without those that follow would be too stiff. */
  truncate(rank: number): Model;
  /** Steps the lowest `masters` coordinates while all others follow at rest. */
  condense(masters: number): Model;
  /** The same body with lengths, Young's modulus and density times these factors. */
  scale(by: { length?: number; stiffness?: number; density?: number }): Model;
  /** The load on the coordinates, `shown` of them: a force [N] shared by a place, gravity [m/s^2], or both. */
  externalLoad(load: Place & { force?: Vector; gravity?: Vector }): Float64Array;
  /** The force on the stepped coordinates (r) at q (r) of a load on all `shown` ones. */
  condensedLoad(q: ArrayLike<number>, load: ArrayLike<number>): Float64Array;
  /** All `shown` coordinates at the stepped ones (r). */
  shape(q: ArrayLike<number>, load?: ArrayLike<number>): Float64Array;
  /** q (`shown`) with coordinate `mode` (0-based) such that no vertex moves further than |amplitude| [m]. */
  start(mode: number, amplitude: number): Float64Array;
  /** Displacements [m], 3 n, at q (`shown`). */
  displacement(q: ArrayLike<number>): Float64Array;
  /** Von Mises' stress at the centre of every tetrahedron [Pa] at q (`shown`). It is larger at the surface of a body that is bent or
   * twisted: `stressNodes` has it there. */
  vonMises(q: ArrayLike<number>): Float64Array;
  /** Static equilibrium under a load (r), from rest or from the equilibrium `from`. */
  equilibrium(load: ArrayLike<number>, from?: ArrayLike<number>): Equilibrium;
  /** The outer triangles of the mesh, counter-clockwise from outside. */
  outerTriangles(): Int32Array;
  state(options?: StateOptions): State;
  batch(states: readonly State[]): Batch;
  surface(options?: { vertices?: Iterable<number>; triangles?: ArrayLike<number> & Iterable<number> }): Surface;
  /** Stress at the nodes of its mesh. */
  stressNodes(): StressNodes;
  /** Makes a run that can be differentiated, by energy, newmark, midpoint or verlet. */
  rollout(steps: number, options?: RolloutOptions): Rollout;
  /** The loss of a run and its gradient; of an array of options one of each. */
  valueAndGradient(loss: Loss, steps: number, options?: RolloutOptions): { value: number; gradient: Gradient };
  valueAndGradient(loss: Loss, steps: number, options: readonly RolloutOptions[]): { value: number; gradient: Gradient }[];
}

export interface RolloutOptions extends StateOptions {
  /** The start (r each); undefined: zero. */
  q?: ArrayLike<number>;
  p?: ArrayLike<number>;
  /** The force of each step (steps x `shown`); undefined: none. */
  force?: ArrayLike<number>;
}

/** Gets q and p after each step, the start first ((steps + 1) x r each), and returns its value and its derivatives by both; undefined:
 * it does not depend on that one. */
export type Loss = (q: Float64Array, p: Float64Array) => { value: number; q?: ArrayLike<number>; p?: ArrayLike<number> };

/** Derivatives of a loss by what a run depends on; thrum_tape_gradient says what each is. */
export interface Gradient {
  q: Float64Array;
  p: Float64Array;
  /** By the force of each step, steps x `shown`. */
  force: Float64Array;
  /** By the damping of each coordinate [1/s], r. */
  damping: Float64Array;
  /** By dampingAlpha, dampingBeta, and factors of Young's modulus and of the density. */
  alpha: number;
  beta: number;
  stiffness: number;
  density: number;
}

/** A run that was recorded. */
export class Rollout implements Freed {
  private constructor();
  free(): void;
  readonly model: Model;
  readonly steps: number;
  readonly rank: number;
  /** After each step, the start first, (steps + 1) x r; copies. */
  readonly q: Float64Array;
  readonly p: Float64Array;
  /** The gradient of a loss from its derivatives by q and p, (steps + 1) x r each; undefined: it does not depend on that one. */
  pullBack(q?: ArrayLike<number>, p?: ArrayLike<number>): Gradient;
}

export interface StateOptions {
  /** Default 'energy'. */
  integrator?: Integrator;
  /** Time step [s], default 0.003. */
  dt?: number;
  /** Rayleigh damping [1/s] and [s], default 0. */
  dampingAlpha?: number;
  dampingBeta?: number;
  /** Of implicit solves; default the integrator's own. */
  tolerance?: number;
  /** Of imexv's split, default 0.5. */
  splitSafety?: number;
  /** Monitors and fallbacks, default on. */
  adaptive?: boolean;
  fallback?: boolean;
}

export interface Report {
  steps: number;
  /** [s] */
  time: number;
  iterations: number;
  switchedSteps: number;
  grownSteps: number;
  explicitModes: number;
  implicitModes: number;
  /** Energy that damping took [J]. */
  dissipated: number;
  scheme: string;
}

/** A body at a time. */
export class State implements Freed {
  private constructor();
  free(): void;
  readonly model: Model;
  /** Coordinates [kg^1/2 m] and momenta [kg^1/2 m/s], r each; copies. */
  readonly q: Float64Array;
  readonly p: Float64Array;
  readonly energies: { kinetic: number; potential: number; total: number };
  readonly report: Report;
  set(q?: ArrayLike<number>, p?: ArrayLike<number>): void;
  /** The load of the steps to come (r); undefined: none. */
  setForce(force?: ArrayLike<number>): void;
  setDt(dt: number): void;
  /** Makes `count` steps (at most 1e7, which nothing interrupts); returns a Status of the most notable one. */
  step(count?: number): number;
  snapshot(): Uint8Array;
  restore(snapshot: Uint8Array): void;
}

/** States of one model that are stepped side by side. */
export class Batch implements Freed {
  private constructor();
  free(): void;
  readonly states: State[];
  /** Makes `count` steps (at most 1e7, which nothing interrupts) of every state; the statuses of the last, below 0 where a state failed. */
  step(count?: number): Int32Array;
}

/** Positions and normals for drawing: Float32Array of three numbers a vertex, as three.js takes them. */
export class Surface implements Freed {
  private constructor();
  free(): void;
  readonly vertexCount: number;
  readonly shown: number;
  readonly triangles: Int32Array | undefined;
  /** Positions [m] at q (`shown`), into `out` if it is given. */
  positions(q: ArrayLike<number>, out?: Float32Array): Float32Array;
  /** Unit normals from positions; the surface has triangles. */
  normals(positions: Float32Array, out?: Float32Array): Float32Array;
}

/** Stress at each vertex of a mesh, once for each region that meets there, by vertex and then by region. In ten-node tetrahedra
 * it is extrapolated to the nodes and averaged within a region. In linear ones it is the average of a patch, which lags behind the stress
 * at a surface. */
export class StressNodes implements Freed {
  private constructor();
  free(): void;
  readonly count: number;
  readonly shown: number;
  /** 0-based vertex and region of each node. */
  readonly vertices: Int32Array;
  readonly regions: Int32Array;
  /** False: averages of patches of linear tetrahedra. */
  readonly extrapolated: boolean;
  /** At q (`shown`): the Cauchy stress xx, yy, zz, xy, yz, xz of each node [Pa], and von Mises' of it [Pa]. NaN next to a tetrahedron
   * that is turned inside out. */
  read(q: ArrayLike<number>): { cauchy: Float64Array; vonMises: Float64Array };
}

export interface BodyOptions {
  /** Default 'energy'. */
  integrator?: Integrator;
  /** Rayleigh damping [1/s] and [s], default 0. */
  dampingAlpha?: number;
  dampingBeta?: number;
  /** Vertices that may touch obstacles; 'all': those of the triangles. */
  touch?: Iterable<number> | 'all';
@BODY@
}

/** Contact between the bodies of a scene. */
export interface CollisionOptions {
@PAIRS@
}

/** The air that goes past bodies with triangles. */
export interface WindOptions {
@WIND@
}

/** With how few coordinates a body is stepped while it is far or still. */
export interface DetailOptions {
  /** Coordinates that are stepped then, the others following. */
  masters: number;
  /** No vertex jumps further at a change [m]. */
  jump: number;
  /** It is far beyond this distance from the eye [m]; default never. */
  beyond?: number;
  /** It is still while no vertex moves faster [m/s]; default never. */
  still?: number;
}

/** What vertices of bodies touch. */
export interface ObstacleOptions {
  /** Of a box: a quaternion w, x, y, z. */
  rotation?: ArrayLike<number>;
@OBSTACLE@
}

/** An obstacle that bodies with triangles touch by its faces. */
export interface SolidOptions {
@SOLID@
}

export type LoadOptions = Place & {
  /** [N], or in its place an acceleration [m/s^2]. */
  force?: Vector;
  acceleration?: Vector;
  /** Grows from 0 at its start to all of it at its end. */
  ramp?: boolean;
@LOAD@
};

/** A spring or joint between places of two bodies, or of a body and the world. */
export interface LinkOptions extends Place {
  /** A joint keeps two places together; a hinge also the direction of its axis, a weld all directions. */
  kind: 'spring' | 'ball' | 'hinge' | 'weld';
  body: Body;
  /** Default the world. */
  other?: Body;
  otherGroup?: string;
@LINK@
}

/** Placed bodies in one world. */
export class Scene implements Freed {
  private constructor();
  free(): void;
  readonly bodies: Body[];
  readonly links: Link[];
  /** [s] */
  readonly time: number;
  addBody(model: Model, options?: BodyOptions): Body;
  setGravity(gravity: Vector): void;
  /** Velocity of the air [m/s], its density [kg/m^3], drag coefficient. */
  setWind(velocity: Vector, options?: WindOptions): void;
  /** Returns its number. */
  addObstacle(obstacle: ObstacleOptions): number;
  setObstacle(number: number, obstacle: ObstacleOptions): void;
  /** Returns its number, apart from those of obstacles. */
  addSolid(solid: SolidOptions): number;
  /** Links two bodies, or a body and the world, as they are now. */
  addLink(link: LinkOptions): Link;
  /** Makes bodies with triangles touch each other from now on; false: they pass through each other. Condensed ones do not touch. */
  setCollisions(options?: CollisionOptions | false): void;
  /** Contact between the bodies: touches, groups without it [1], distances [m], the sum of the forces [N], energies [J]. */
  readonly collisions: {
    touching: number; declined: number; distance: number; depth: number; deepestShare: number; normal: number;
    stored: number; lost: number;
  };
  /** The body that lies deepest, for its size, inside another or inside the obstacle or solid of this number; depth [m]. */
  findOverlap(): { body: Body; other?: Body; obstacle?: number; solid?: number; depth: number } | undefined;
  /** Energies [J], momentum [kg m/s] and angular momentum [kg m^2/s] of all bodies together. */
  readonly account: {
    kinetic: number; potential: number; gravity: number; contact: number; links: number; total: number;
    momentum: number[]; angularMomentum: number[];
  };
  /** Place that distances of bodies with a level of detail are from [m]. */
  setEye(place: Vector): void;
  /** Looks at all bodies with a level of detail; call it every few steps. */
  updateDetail(): void;
  /** Makes `count` steps (at most 1e7, which nothing interrupts); returns a Status. Throws after a step in which a body failed; the others made it. */
  step(count?: number): number;
  setDt(dt: number): void;
  reset(): void;
  snapshot(): Uint8Array;
  restore(snapshot: Uint8Array): void;
}

export class Body {
  private constructor();
  readonly scene: Scene;
  readonly model: Model;
  readonly number: number;
  readonly q: Float64Array;
  readonly p: Float64Array;
  readonly info: {
    status: number; rank: number; shown: number; touching: number; fallbackSteps: number;
    grownSteps: number; switchedSteps: number; scheme: string;
  };
  /** [J] */
  readonly energies: { kinetic: number; potential: number; gravity: number; contact: number; total: number };
  /** From the model's coordinates to the world, 4 x 4 column-major, as three.js takes it. */
  readonly matrix: number[];
  /** Positions of a surface of its model, in the model's coordinates. */
  positions(surface: Surface, out?: Float32Array): Float32Array;
  /** Position [m] and velocity [m/s] of a vertex in the world. */
  vertex(vertex: number): { position: number[]; velocity: number[] };
  setDamping(alpha: number, beta?: number): void;
  /** A level of detail, which Scene.updateDetail looks after; undefined: the number of coordinates stays as it is. */
  setDetail(detail?: DetailOptions): void;
  /** What it has done; the largest jump [m], the energy that changes gave [J]. */
  readonly detail: { reduced: boolean; changes: number; reducedSteps: number; largestJump: number; energy: number };
  addLoad(load: LoadOptions): void;
  /** A spring [N/m], [N s/m; below 0: critical] from a vertex to a target [m]. */
  pull(vertex: number, target: Vector, spring: { stiffness: number; damping?: number }): Pull;
}

/** A link as it is now. */
export class Link {
  private constructor();
  readonly scene: Scene;
  readonly number: number;
  readonly kind: 'spring' | 'ball' | 'hinge' | 'weld';
  /** false: it has let go, as it does after a body of it failed. */
  readonly holds: boolean;
  /** What it ties; the second undefined: the world. */
  readonly bodies: [Body, Body | undefined];
  /** Of a spring without force [m]. */
  readonly length: number;
  /** Where its two ends are [m]. */
  readonly places: [number[], number[]];
  /** Mean force of the last step on the place of the first body [N], and torque about it [N m]. */
  readonly force: number[];
  readonly torque: number[];
  /** How far a joint is open, and was after any step but its first two [m]; energy stored in a spring now, lost and driven [J]. */
  readonly report: { drift: number; largestDrift: number; stored: number; lost: number; driven: number };
  /** Lets it go from now on. */
  release(): void;
}

export class Pull {
  private constructor();
  move(target: Vector): void;
  end(): void;
  /** Mean force of the last step [N]. */
  readonly force: number[];
}

/** An instance of the engine: models of one instance do not go into scenes of another. */
export interface Thrum {
  readonly version: string;
  readonly integrators: Integrator[];
  /** The model of a file's bytes (.npz), which are copied. */
  model(bytes: ArrayBuffer | ArrayBufferView): Model;
  scene(options?: { dt?: number; gravity?: Vector }): Scene;
}

/** The engine from its binary: bytes, or a module compiled from them. */
export function loadFrom(wasm: BufferSource | WebAssembly.Module): Promise<Thrum>;
