"""Ten thousand runs."""
import gc
import os

import viscobar
from support import Test, main, thrown


class LeaksTest(Test):
    def test_ten_thousand_runs_leave_nothing_behind(self):
        scene = thrown(time__end=0.3, mesh__elements=4, load__density=lambda x, t: 0.1 * x)
        scene["mesh"]["mass"] = "consistent"

        def memory():
            gc.collect()
            with open("/proc/self/statm") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

        def runs(count):
            for _ in range(count):
                result = viscobar.run(scene)
                result.ends, result.events, result.summary

        runs(1000)  # until arenas and caches have their size
        before = memory()
        runs(10000)
        # 256 KiB are 26 bytes a run: less than any object.
        self.assertLess(memory() - before, 256 * 1024)


if __name__ == "__main__":
    main()
