"""viscobar.run(): the numbers of the program, arrays, Python functions, stops."""
import gc
import os
import signal
import threading
import time
import traceback
import warnings

import numpy as np

import viscobar
from support import SCENES, Test, long_scene, main, program_result, thrown

warnings.simplefilter("ignore", viscobar.RunWarning)


class NumbersTest(Test):
    # Differ from run to run, or say which files there are, or which executable it was.
    APART = {"wall_seconds", "integration_seconds", "files", "crc64", "versions"}

    def check(self, scene, **changes):
        keys = {key.replace("__", "."): value for key, value in changes.items()}
        options = [f"--set={key}={'' if value is None else value}" for key, value in keys.items()]
        ends, events, summary = program_result(SCENES / scene, *options)
        result = viscobar.run(viscobar.load(SCENES / scene), set=keys)
        self.assertEqual(list(result.ends), list(ends))
        for column, values in ends.items():
            self.assertTrue(np.array_equal(result.ends[column], values), column)
        self.assertEqual(len(result.events), len(events))
        for ours, theirs in zip(result.events, events):
            self.assertEqual([ours["t"], ours["where"], ours["change"], ours["velocity"]],
                             [float(theirs[0]), theirs[1], theirs[2], float(theirs[3])])  # fmt: skip
        ours = {key: value for key, value in result.summary.items() if key not in self.APART}
        self.assertEqual(ours, {key: value for key, value in summary.items() if key not in self.APART})

    def test_of_a_chattering_bar_are_those_of_the_program_bit_for_bit(self):
        self.check("chatter.toml")

    def test_of_every_method_are_those_of_the_program_bit_for_bit(self):
        for method in ("automatic", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete"):
            with self.subTest(method):
                self.check("chatter.toml", method__name=method, contact__restitution=0, time__end=2)

    def test_of_the_exact_bar_are_those_of_the_program_bit_for_bit(self):
        self.check("bouncing.toml")

    def test_of_finite_differences_under_a_loaded_span_are_those_of_the_program_bit_for_bit(self):
        self.check("unit-span-loaded.toml", method__name="finite_difference")

    def test_of_the_paper_loaded_are_those_of_the_program_bit_for_bit(self):
        self.check("paper-both-ends-loaded.toml", time__end=5)

    def test_of_a_dictionary_are_those_of_the_file_bit_for_bit(self):
        scene = viscobar.load(SCENES / "chatter.toml")
        one, other = viscobar.run(dict(scene)), viscobar.run(SCENES / "chatter.toml")
        self.assertTrue(np.array_equal(one.u, other.u))


class AccuracyTest(Test):
    SCENE = {
        "bar": {"length": 1.0, "viscosity": 0.1},
        "left": {"kind": "obstacle", "gap": 0.0},
        "initial": {"velocity": -1.0},
        "time": {"end": 2.5},
    }

    def test_on_request_is_kept_and_told(self):
        result = viscobar.run(self.SCENE, error=1e-6, set={"accuracy.of": "contact_times"})
        self.assertTrue(result.error_estimate["kept"])
        self.assertLessEqual(abs(result.events["t"][-1] - 1.9124710098), 1e-6)
        self.assertEqual(len(result.x), result.summary["scene"]["mesh"]["elements"] + 1)

    def test_that_the_scene_forbids_is_a_warning_and_not_kept(self):
        result = viscobar.run(self.SCENE, error=1e-6, set={"mesh.elements": 10})
        self.assertFalse(result.error_estimate["kept"])
        self.assertIn("mesh.elements = 10 is kept", result.warnings[-1])

    def test_of_initial_data_as_functions_is_kept(self):
        scene = viscobar.Scene(self.SCENE).changed({"initial.velocity": lambda x: -1.0})
        self.assertTrue(viscobar.run(scene, error="0.01 %").error_estimate["kept"])

    def test_is_not_estimated_where_nothing_was_asked_for(self):
        self.assertIsNone(viscobar.run(self.SCENE).error_estimate)


class ArraysTest(Test):
    def test_of_a_dictionary_with_driven_ends_have_their_motion_and_energy(self):
        tables = {
            "bar": {"length": 1.0, "viscosity": 0.05},
            "left": {"kind": "obstacle", "gap": "0.1-0.05*sin(3*t)", "force": "-sin(t)", "stiffness": 0.5, "dashpot": 0.2},
            "right": {"kind": "fixed", "motion": "0.05*(1-cos(2*t))"},
            "time": {"end": 2.0},
            "mesh": {"elements": 10, "mass": "consistent"},
            "contact": {"epsilon": 1e-3},
            "method": {"name": "cvode"},
        }
        result = viscobar.run(tables)
        self.assertTrue(np.array_equal(result.ends["u_right"][[0, -1]], [0.0, 0.05 * (1 - np.cos(4.0))]))
        energy = result.energy
        account = result.summary["energy"]
        total = energy["kinetic"] + energy["elastic"] + energy["contact"]
        self.assertLess(abs(total[-1] - account["final"]), 1e-12)
        self.assertLess(abs(account["balance_error"]), 1e-6)

    def test_have_the_shapes_that_the_docs_say(self):
        result = viscobar.run(thrown())
        self.assertEqual((result.t.shape, result.x.shape, result.u.shape, result.v.shape, result.stress.shape),
                         ((31,), (21,), (31, 21), (31, 21), (31, 20)))  # fmt: skip
        self.assertTrue(all(column.shape == (31,) for column in [*result.ends.values(), *result.energy.values()]))

    def test_are_views_of_the_memory_of_the_library_and_outlive_the_result(self):
        result = viscobar.run(thrown())
        u = result.u
        self.assertFalse(u.flags.owndata)
        self.assertTrue(np.shares_memory(u, result.ends["u_left"]))
        kept = u.copy()
        del result
        gc.collect()
        self.assertTrue(np.array_equal(u, kept))

    def test_of_stress_have_the_reaction_at_the_massless_contact_node(self):
        result = viscobar.run(thrown())  # without inertia the node's row is R = -s
        self.assertGreater(result.ends["reaction_left"].max(), 0.5)
        # s is a difference of displacements divided by h: roundings of u times E/h, of v times eta/h, some ten of them.
        rounding = 10 * np.finfo(float).eps * 20 * (np.abs(result.u).max() + np.abs(result.v).max())
        closed = result.ends["reaction_left"] > 0
        error = np.abs(result.ends["reaction_left"] + result.stress[:, 0])[closed]
        # In contact u_t of the node follows from the same row, to the tolerance of the method.
        self.assertLess(error.max(), max(rounding, 100 * 1e-6 * np.abs(result.stress).max()))

    def test_of_energy_begin_and_end_with_those_of_the_summary(self):
        for method in ("cvode", "rigid", "fully_discrete"):
            result = viscobar.run(thrown(), method)
            account = result.summary["energy"]
            # The same numbers by another way; the scheme's energy is that of its half step, dt / 2 away.
            near = 1e-2 if method == "fully_discrete" else 1e-9
            self.assertAlmostEqual(result.energy["total"][0], account["initial"], delta=near)
            self.assertAlmostEqual(result.energy["total"][-1], account["final"], delta=near)
            for name in ("dissipated", "work"):
                self.assertAlmostEqual(result.energy[name][-1], account[name], delta=1e-14)


class FunctionsTest(Test):
    def test_as_initial_data_give_what_the_formulas_give(self):
        formulas = viscobar.run(thrown(initial__displacement="x*(1-x)", initial__velocity="-1-x"))
        functions = viscobar.run(
            thrown(initial__displacement=lambda x: x * (1 - x), initial__velocity=lambda x: -1 - x)
        )
        self.assertTrue(np.array_equal(formulas.u, functions.u))
        self.assertIn("function", functions.summary["scene"]["initial"]["displacement"])

    def test_as_loads_give_what_the_formulas_give(self):
        formulas = viscobar.run(thrown(load__density="0.5*x*t"))
        for load in (
            {"density": lambda x, t: 0.5 * x * t},  # all nodes in one call
            {"density": lambda x, t: 0.5 * float(x) * t},  # node by node
            {"profile": lambda x: 0.5 * x, "history": "t"},
            {"profile": "0.5*x", "history": lambda t: t},
            {"profile": lambda x: 0.5 * x, "history": lambda t: t},
        ):
            functions = viscobar.run({**thrown(), "load": load})
            # The same motion within the tolerance: products are formed in another order, which steps may follow.
            self.assertLess(np.abs(functions.u - formulas.u).max(), 100 * 1e-6 * np.abs(formulas.u).max())
        steady = viscobar.run({**thrown(), "load": {"profile": lambda x: 0.5 * x, "history": 2.0}})
        self.assertLess(np.abs(steady.u - viscobar.run(thrown(load__density="x")).u).max(), 1e-4)

    def test_of_arrays_are_called_once_a_time(self):
        calls = []
        viscobar.run(thrown(load__density=lambda x, t: calls.append(np.size(x)) or 0.1 * x * np.cos(t)))
        self.assertEqual(calls[1:4], [1, 1, 1])  # looked at node by node first, to see that it is the same function
        self.assertEqual(set(calls[4:]), {21})

    def test_that_raise_come_out_as_they_are(self):
        class Own(Exception):
            pass

        def load(x, t):
            if t > 1.0:
                raise Own("at", t)
            return 0.0 * x

        for method in ("cvode", "ida", "arkode", "odeint", "rigid", "exponential", "fully_discrete"):
            with self.subTest(method):
                try:
                    viscobar.run(thrown(load__density=load, mesh__mass="consistent", mesh__elements=8), method)
                    self.fail("nothing was raised")
                except Own as raised:
                    self.assertEqual(raised.args[0], "at")
                    frames = [frame.name for frame in traceback.extract_tb(raised.__traceback__)]
                    self.assertEqual(frames[-1], "load")
                    self.assertFalse(raised.result.completed)
        with self.assertRaises(ZeroDivisionError):
            viscobar.run(thrown(initial__velocity=lambda x: 1 / x))

    def test_that_return_no_number_are_named_by_their_keys(self):
        with self.assertRaisesRegex(TypeError, "load.density: the function returned NoneType"):
            viscobar.run(thrown(load__density=lambda x, t: None))
        with self.assertRaisesRegex(TypeError, "initial.velocity: the function returned str"):
            viscobar.run(thrown(initial__velocity=lambda x: "fast"))
        with self.assertRaisesRegex(viscobar.IntegrationError, "not a number"):
            viscobar.run(thrown(load__density=lambda x, t: np.nan * x if t > 0.5 else x))

    def test_of_an_observer_see_each_output_time_and_change(self):
        times, changes = [], []
        result = viscobar.run(
            thrown(), observer=lambda t, u, v: times.append((t, u[0], v.shape)), on_event=changes.append
        )
        self.assertEqual([row[0] for row in times], list(result.t))
        self.assertEqual([row[1] for row in times], list(result.ends["u_left"]))
        self.assertEqual([row["t"] for row in changes], list(result.events["t"]))
        self.assertEqual(changes[0]["change"], "closing")

    def test_of_an_observer_stop_a_run_which_keeps_what_it_reached(self):
        whole = viscobar.run(thrown())
        for options in ({"observer": lambda t, u, v: t >= 1.0}, {"on_event": lambda event: event["change"] == "opening"}):
            result = viscobar.run(thrown(), **options)
            self.assertFalse(result.completed)
            self.assertEqual(result.summary["ending"], "interrupted")
            self.assertLess(len(result.t), 31)
            self.assertGreater(len(result.t), 9)
            self.assertTrue(np.array_equal(result.u, whole.u[: len(result.t)]))
            self.assertIsNotNone(result.summary["linear_solves"])
        with self.assertRaises(KeyError) as raised:
            viscobar.run(thrown(), observer=lambda t, u, v: {}["no"])
        self.assertEqual(len(raised.exception.result.t), 1)

    def test_may_run_scenes_themselves(self):
        inner = []
        viscobar.run(thrown(), observer=lambda t, u, v: inner.append(viscobar.run(thrown()).u[-1, 0]) and False)
        self.assertEqual(len(set(inner)), 1)


class StopsTest(Test):
    def interrupted(self, after, call):
        """Seconds from the signal to the exception, and the exception. The signal comes when the call has had so many seconds
        of the processor, which other programs use, too."""
        sent = []
        begun = time.process_time()

        def send():
            while time.process_time() - begun < after:
                time.sleep(0.005)
            sent.append(time.perf_counter())
            os.kill(os.getpid(), signal.SIGINT)

        sender = threading.Thread(target=send)
        sender.start()
        with self.assertRaises(KeyboardInterrupt) as raised:
            call()
        late = time.perf_counter() - sent[0]
        sender.join()
        return late, raised.exception

    def test_by_control_c_take_less_than_a_tenth_of_a_second_and_keep_what_was_reached(self):
        # The best of three: other programs may have the processor when the signal comes.
        stops = [self.interrupted(0.4, lambda: viscobar.run(long_scene())) for _ in range(3)]
        self.assertLess(min(late for late, _ in stops), 0.1)
        for _, stopped in stops:
            result = stopped.result
            self.assertFalse(result.completed)
            self.assertGreater(result.reached_time, 0.0)
            self.assertGreater(len(result.t), 0)
            self.assertGreater(result.summary["steps"], 100)
            self.assertGreater(result.summary["linear_solves"], 100)

    def test_by_control_c_work_within_a_function_too(self):
        scene = long_scene()
        scene["load"] = {"density": lambda x, t: 0.1 * x * np.sin(50 * t)}
        late, stopped = self.interrupted(0.3, lambda: viscobar.run(scene))
        self.assertLess(late, 1.0)
        self.assertFalse(stopped.result.completed)

    def test_by_control_c_end_comparisons_and_sweeps(self):
        late, _ = self.interrupted(0.3, lambda: viscobar.compare(long_scene(), ["cvode", "arkode"]))
        self.assertLess(late, 1.0)
        t = np.linspace(0.0, 400.0, 50)
        fitted = thrown(time__end=400.0, mesh__elements=4000)
        late, _ = self.interrupted(0.5, lambda: viscobar.fit(fitted, ["bar.viscosity"], data={"t": t, "u_left": -np.cos(t)}))
        self.assertLess(late, 2.0)
        # Bars by the method of the scene, one at a time, and bars side by side.
        fine, plain = thrown(time__end=400.0, mesh__elements=10_000), thrown(time__end=400.0)
        del plain["method"], plain["contact"], plain["mesh"]["mass"]
        for scene, bars, error in ((fine, 64, None), (plain, 60_000, 1e-3)):
            varied = {"bar.viscosity": np.linspace(0.01, 1.0, bars)}
            late, _ = self.interrupted(0.5, lambda: viscobar.ensemble(scene, varied, "final", error=error))
            self.assertLess(late, 2.0)
        # In its timed runs, and in a reference, which may take twenty times as long.
        for after, end, seconds in ((0.5, 1e6, 60.0), (3.0, 400.0, 5.0)):
            study = lambda: viscobar.precision(
                long_scene(), methods=["rigid"], tolerances=[1e-2], set={"time.end": end}, seconds=seconds
            )
            late, _ = self.interrupted(after, study)
            self.assertLess(late, 1.0)
        late, stopped = self.interrupted(0.6, lambda: viscobar.sweep(long_scene(), {"time.end": [2000.0, 1e6, 2e6]}))
        self.assertLess(late, 1.0)
        self.assertLess(len(stopped.rows), 3)

    def test_leave_other_threads_running(self):
        stop, slept = threading.Event(), []
        scene = long_scene()
        scene["output"]["every"] = 1.0  # some 20 ms of work: who waits for Python's lock would wait so long
        runner = threading.Thread(target=lambda: viscobar.run(scene, observer=lambda t, u, v: stop.is_set()))
        runner.start()
        for _ in range(50):
            begun = time.perf_counter()
            time.sleep(0.001)
            slept.append(time.perf_counter() - begun)
        stop.set()
        runner.join()
        self.assertLess(sorted(slept)[25], 0.01)

    def test_of_several_runs_at_once_have_the_numbers_of_one(self):
        alone = viscobar.run(thrown()).u
        results = [None] * 4

        def go(k):
            for _ in range(10):
                results[k] = viscobar.run(thrown(load__density=lambda x, t: 0.0 * x)).u

        threads = [threading.Thread(target=go, args=(k,)) for k in range(4)]
        for one in threads:
            one.start()
        for one in threads:
            one.join()
        for one in results:
            self.assertLess(np.abs(one - alone).max(), 1e-4)
            self.assertTrue(np.array_equal(one, results[0]))


class FailuresTest(Test):
    def test_keep_what_was_reached(self):
        with self.assertRaises(viscobar.IntegrationError) as raised:
            viscobar.run(thrown(load__density="1/(1-t)"))
        result = raised.exception.result
        self.assertFalse(result.completed)
        self.assertEqual(result.summary["ending"], "failed")
        self.assertGreater(len(result.t), 5)

    def test_of_memory_are_foreseen(self):
        with self.assertRaises(viscobar.SceneError) as raised:
            viscobar.run(thrown(output__every=1e-7, mesh__elements=100000))
        self.assertEqual(raised.exception.key, "output.every")

    def test_warnings_are_warnings_of_python(self):
        with self.assertWarnsRegex(viscobar.RunWarning, "^chatter: "):
            viscobar.run(SCENES / "chatter.toml")


if __name__ == "__main__":
    main()
