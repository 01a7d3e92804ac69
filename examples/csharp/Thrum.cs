// Thrum from C#, by P/Invoke: models, states, steps, loads and vertices for drawing. One file, without packages, for
// .NET, mono and Unity: put it beside your scripts, and libthrum (libthrum.so.0.2 of the package libthrum0.2, or
// libthrum.so of a build with -DBUILD_SHARED_LIBS=ON) where the loader finds it.
//
// Quantities are SI. Structs have the fields of include/thrum/*.h in their order. A model may be used by any number of
// threads; a state by one at a time. SPDX-License-Identifier: Apache-2.0
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Thrum {
  /// <summary>Integrators, as in thrum/state.h.</summary>
  public enum Integrator { Imexv, Newmark, Verlet, Midpoint, Energy, FoxGoodwin, BackwardEuler, SemiImplicitEuler, Rk4, Manifold }

  /// <summary>thrum_error: the status and one line for a person.</summary>
  [StructLayout(LayoutKind.Sequential)]
  public struct NativeError {
    public int Status;
    [MarshalAs(UnmanagedType.ByValArray, SizeConst = 400)] public byte[] Message;
  }

  /// <summary>thrum_state_def: how a state is stepped. Take StateDef.Default and change what is wanted.</summary>
  [StructLayout(LayoutKind.Sequential)]
  public struct StateDef {
    public uint Cookie;
    public Integrator Integrator;
    public double Dt;
    public double DampingAlpha;
    public double DampingBeta;
    public int DampingForm;
    public int SplitRule;
    public double SplitSafety;
    public double NewmarkBeta;
    public double NewmarkGamma;
    public double Tolerance;
    public double PlasticYield;
    public double PlasticCreep;
    public double PlasticLargest;
    public int ExplicitCount;
    public int IterationsMax;
    public int Kernel;
    public int SplitForm;
    public int Adaptive;
    public int Fallback;
    public int Solver;
    public int FrequencyMatched;
    public int BorrowsScratch;
    public int UntrainedFlow;

    public static StateDef Default {
      get {
        StateDef def = new StateDef();
        Native.thrum_state_def_init(ref def, (UIntPtr)(uint)Marshal.SizeOf(typeof(StateDef)));
        return def;
      }
    }
  }

  /// <summary>thrum_energies [J].</summary>
  [StructLayout(LayoutKind.Sequential)]
  public struct Energies {
    public double Kinetic;
    public double Potential;
    public double Total;
    public double High;
  }

  /// <summary>What the library refuses: its one line.</summary>
  public class ThrumException : Exception {
    public readonly int Status;
    public ThrumException(int status, string message) : base(message) { Status = status; }
  }

  /// <summary>The functions of libthrum as they are.</summary>
  public static class Native {
    public const string Library = "thrum";

    [DllImport(Library)] public static extern IntPtr thrum_version();
    [DllImport(Library)] public static extern void thrum_state_def_init(ref StateDef def, UIntPtr size);
    [DllImport(Library)] public static extern int thrum_model_load(byte[] path, out IntPtr model, ref NativeError error);
    [DllImport(Library)] public static extern void thrum_model_destroy(IntPtr model);
    [DllImport(Library)] public static extern int thrum_state_create(IntPtr model, ref StateDef def, out IntPtr state, ref NativeError error);
    [DllImport(Library)] public static extern void thrum_state_destroy(IntPtr state);
    [DllImport(Library)] public static extern int thrum_state_set(IntPtr model, IntPtr state, double[] q, double[] p, ref NativeError error);
    [DllImport(Library)] public static extern int thrum_state_get(IntPtr model, IntPtr state, double[] q, double[] p, ref NativeError error);
    [DllImport(Library)] public static extern int thrum_state_set_force(IntPtr model, IntPtr state, double[] force, ref NativeError error);
    [DllImport(Library)] public static extern int thrum_steps(IntPtr model, IntPtr state, long count, IntPtr done, ref NativeError error);
    [DllImport(Library)] public static extern int thrum_state_energies(IntPtr model, IntPtr state, out Energies energies, ref NativeError error);
    [DllImport(Library)] public static extern int thrum_mode_add(IntPtr model, long mode, double amplitude, double[] q, ref NativeError error);
    [DllImport(Library)] public static extern int thrum_load_add_vertex(IntPtr model, long vertex, double[] force, double[] reduced, ref NativeError error);
    [DllImport(Library)] public static extern int thrum_displacement(IntPtr model, double[] q, long first, long count, double[] displacements, ref NativeError error);

    internal static int Check(int status, ref NativeError error) {
      if (status >= 0)
        return status;
      int length = Array.IndexOf(error.Message, (byte)0);
      throw new ThrumException(status, Encoding.UTF8.GetString(error.Message, 0, Math.Max(length, 0)));
    }

    internal static NativeError NewError() { return new NativeError { Message = new byte[400] }; }
  }

  /// <summary>A reduced model, read from a file of thrum precompute. Dispose it after its states.</summary>
  public sealed class Model : IDisposable {
    internal IntPtr Handle;
    /// <summary>Number of coordinates r.</summary>
    public readonly int Rank;
    /// <summary>Number of vertices n.</summary>
    public readonly int VertexCount;

    public Model(string path) {
      NativeError error = Native.NewError();
      Native.Check(Native.thrum_model_load(Encoding.UTF8.GetBytes(path + "\0"), out Handle, ref error), ref error);
      // the first fields of thrum_model: rank, c3_count, c4_count, vertex_count
      Rank = (int)Marshal.ReadInt64(Handle, 0);
      VertexCount = (int)Marshal.ReadInt64(Handle, 24);
    }

    public void Dispose() {
      Native.thrum_model_destroy(Handle);
      Handle = IntPtr.Zero;
    }

    /// <summary>The reduced load (r) of a force [N] at one vertex (0-based).</summary>
    public double[] VertexLoad(int vertex, double x, double y, double z) {
      double[] load = new double[Rank];
      NativeError error = Native.NewError();
      Native.Check(Native.thrum_load_add_vertex(Handle, vertex, new[] { x, y, z }, load, ref error), ref error);
      return load;
    }

    /// <summary>Coordinates (r) of one mode, scaled so that no vertex moves further than the amplitude [m].</summary>
    public double[] Start(int mode, double amplitude) {
      double[] q = new double[Rank];
      NativeError error = Native.NewError();
      Native.Check(Native.thrum_mode_add(Handle, mode, amplitude, q, ref error), ref error);
      return q;
    }

    /// <summary>Displacements of all vertices [m], x, y, z of each, into an array of 3 n.</summary>
    public void Displacements(double[] q, double[] into) {
      if (q.Length != Rank || into.Length < 3 * VertexCount)
        throw new ArgumentException("q has r numbers, and the displacements take 3 n");
      NativeError error = Native.NewError();
      Native.Check(Native.thrum_displacement(Handle, q, 0, VertexCount, into, ref error), ref error);
    }
  }

  /// <summary>A body at a time: coordinates, momenta, a load.</summary>
  public sealed class State : IDisposable {
    readonly Model model;
    IntPtr handle;
    NativeError error = Native.NewError();

    public State(Model model, StateDef def) {
      this.model = model;
      Native.Check(Native.thrum_state_create(model.Handle, ref def, out handle, ref error), ref error);
    }

    public void Dispose() {
      Native.thrum_state_destroy(handle);
      handle = IntPtr.Zero;
    }

    double[] Sized(double[] numbers) {
      if (numbers != null && numbers.Length != model.Rank)
        throw new ArgumentException("r numbers are needed");
      return numbers;
    }

    /// <summary>Sets coordinates and momenta; null is zero.</summary>
    public void Set(double[] q, double[] p) { Native.Check(Native.thrum_state_set(model.Handle, handle, Sized(q), Sized(p), ref error), ref error); }

    /// <summary>Copies coordinates and momenta out.</summary>
    public void Get(double[] q, double[] p) { Native.Check(Native.thrum_state_get(model.Handle, handle, Sized(q), Sized(p), ref error), ref error); }

    /// <summary>The load (r) of the steps to come; null is none.</summary>
    public void SetForce(double[] force) { Native.Check(Native.thrum_state_set_force(model.Handle, handle, Sized(force) ?? new double[model.Rank], ref error), ref error); }

    /// <summary>Makes steps; the most notable status among them, 0 for none.</summary>
    public int Step(long count) { return Native.Check(Native.thrum_steps(model.Handle, handle, count, IntPtr.Zero, ref error), ref error); }

    public Energies Energies {
      get {
        Energies found;
        Native.Check(Native.thrum_state_energies(model.Handle, handle, out found, ref error), ref error);
        return found;
      }
    }
  }
}
