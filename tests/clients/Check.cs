// Sizes and places of the structs of examples/csharp/Thrum.cs, and the bits of a run by it, as tests/clients/check.c
// prints them. SPDX-License-Identifier: Apache-2.0
using System;
using System.Runtime.InteropServices;
using Thrum;

static class Check {
  static void Layout(Type type, string name, params string[] fields) {
    Console.WriteLine("{0} {1}", name, Marshal.SizeOf(type));
    foreach (string field in fields)
      Console.WriteLine("{0}.{1} {2}", name, field, Marshal.OffsetOf(type, field));
  }

  static void Main(string[] arguments) {
    Layout(typeof(NativeError), "error", "Message");
    Layout(typeof(StateDef), "def", "Integrator", "Dt", "DampingForm", "SplitSafety", "Tolerance", "ExplicitCount", "Kernel", "Solver", "UntrainedFlow");
    Layout(typeof(Energies), "energies", "Total", "High");

    using (Model model = new Model(arguments[0])) {
      Console.WriteLine("rank {0} vertices {1}", model.Rank, model.VertexCount);
      StateDef def = StateDef.Default;
      def.Dt = 0.002;
      def.DampingAlpha = 0.1;
      using (State state = new State(model, def)) {
        double[] q = model.Start(0, 0.1), p = new double[model.Rank], moved = new double[3 * model.VertexCount];
        state.Set(q, null);
        state.SetForce(model.VertexLoad(model.VertexCount - 1, 0, 1, -2));
        Console.WriteLine("status {0}", state.Step(500));
        state.Get(q, p);
        foreach (double[] numbers in new[] { q, p })
          foreach (double number in numbers)
            Console.WriteLine("{0:x16}", BitConverter.DoubleToInt64Bits(number));
        Console.WriteLine("{0:x16}", BitConverter.DoubleToInt64Bits(state.Energies.Total));
        model.Displacements(q, moved);
        Console.WriteLine("{0:x16}", BitConverter.DoubleToInt64Bits(moved[3 * model.VertexCount - 1]));
        def.Dt = -1;
        try {
          new State(model, def).Dispose();
        } catch (ThrumException exception) {
          Console.WriteLine(exception.Message);
        }
      }
    }
  }
}
