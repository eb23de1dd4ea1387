"""The script that fills figures into README and docs: setup/figures.py and setup/quotes.py."""

import json
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "setup"))
import figures
import quotes
import study_pages


def fill(document, **known):
    """Fills `document` from numbers {id: value} and one table `t`."""
    return quotes.fill(
        "page.md",
        document,
        lambda key: known["numbers"][key],
        lambda key: {"t": known.get("t", "")}[key],
    )


def inline(text, key="a.b"):
    return f"RMS <!-- figure:{key} -->{text}<!-- / --> mm"


class Agree(unittest.TestCase):
    def test_one_in_the_last_digit_is_rounding(self):
        for a, b in (
            ("0.010", "0.010"),
            ("0.010", "0.011"),
            ("0.010", "0.009"),
            ("5", "6"),
            ("49.5", "49.4"),
        ):
            self.assertTrue(quotes.agrees(a, b), (a, b))

    def test_two_are_not(self):
        for a, b in (
            ("0.010", "0.012"),
            ("0.039", "0.044"),
            ("5.00", "4.98"),
            ("5", "7"),
            ("49.5", "49.7"),
        ):
            self.assertFalse(quotes.agrees(a, b), (a, b))

    def test_the_fewer_decimals_count(self):
        self.assertTrue(quotes.agrees("0.1", "0.0998"))
        self.assertFalse(quotes.agrees("0.0990", "0.0998"))

    def test_significant_digits(self):
        for value, text in (
            (0.0098975, "0.0099"),
            (0.24, "0.24"),
            (4.9999, "5.0"),
            (16.48, "16"),
            (150.2, "150"),
            (0, "0"),
        ):
            self.assertEqual(quotes.sized(value), text)


class Numbers(unittest.TestCase):
    def test_a_good_one_stays_and_a_stale_one_is_replaced_and_named(self):
        document = "one\n" + inline("0.010") + "\n" + inline("0.039", "c.d") + "\n"
        filled, stale = fill(document, numbers={"a.b": 0.0098975, "c.d": 0.0436})
        self.assertEqual(filled, document.replace("0.039", "0.044"))
        self.assertEqual(stale, ["page.md:3: c.d is quoted as '0.039', the program gives 0.044"])

    def test_what_stands_there_says_how_many_decimals(self):
        for text, now in (("9.99", "4.99"), ("9.999", "4.985"), ("9", "5"), ("", "5.0")):
            filled, stale = fill(inline(text), numbers={"a.b": 4.98509})
            self.assertEqual(filled, inline(now))
            self.assertEqual(len(stale), 1)

    def test_a_sign_counts(self):
        self.assertEqual(fill(inline("-0.5"), numbers={"a.b": -0.5})[1], [])
        self.assertEqual(len(fill(inline("0.5"), numbers={"a.b": -0.5})[1]), 1)

    def test_filling_twice_changes_nothing(self):
        once, _ = fill(inline("7.00"), numbers={"a.b": 4.98509})
        self.assertEqual(fill(once, numbers={"a.b": 4.98509}), (once, []))

    def test_an_unknown_figure_is_an_error_with_its_place(self):
        with self.assertRaisesRegex(quotes.QuoteError, r"page\.md:2: no figure 'x\.y'"):
            fill("\n" + inline("1", "x.y"), numbers={})

    def test_a_marker_that_is_not_closed_is_an_error(self):
        for broken in (
            "<!-- figure:a.b -->0.1",
            "<!-- figures:table t -->\n| 1 |\n",
            "<!-- figure:a.b --> <!-- figure:a.b -->1<!-- / -->",
        ):
            with self.assertRaisesRegex(quotes.QuoteError, r"page\.md:1: a marker"):
                fill(broken, numbers={"a.b": 0.1})


class Tables(unittest.TestCase):
    DOCUMENT = "before\n<!-- figures:table t -->\n| a | 0.010 |\n<!-- /figures -->\nafter\n"

    def test_rounding_is_not_stale(self):
        self.assertEqual(fill(self.DOCUMENT, t="| a | 0.011 |\n")[1], [])

    def test_a_stale_number_is_replaced_and_named(self):
        filled, stale = fill(self.DOCUMENT, t="| a | 0.013 |\n")
        self.assertEqual(filled, self.DOCUMENT.replace("0.010", "0.013"))
        self.assertEqual(len(stale), 1)
        self.assertIn("page.md:3: table t", stale[0])

    def test_other_words_are_stale(self):
        self.assertEqual(len(fill(self.DOCUMENT, t="| b | 0.010 |\n")[1]), 1)

    def test_another_row_is_stale(self):
        filled, stale = fill(self.DOCUMENT, t="| a | 0.010 |\n| b | 2 |\n")
        self.assertIn("| b | 2 |\n<!-- /figures -->\nafter", filled)
        self.assertEqual(len(stale), 1)

    def test_an_empty_one_is_filled(self):
        filled, stale = fill("<!-- figures:table t -->\n<!-- /figures -->\n", t="| a |\n")
        self.assertEqual(filled, "<!-- figures:table t -->\n| a |\n<!-- /figures -->\n")
        self.assertEqual(len(stale), 1)


class Runs(unittest.TestCase):
    def test_commands_are_ones_that_anybody_can_type(self):
        runs = figures.runs()
        self.assertEqual(runs["bowl-sine"].command(1), ["draw", "scenarios/bowl-sine.yaml"])
        self.assertEqual(
            runs["bowl-sine-realistic"].command(3),
            ["draw", "scenarios/bowl-sine-realistic.yaml", "--set", "seed=3"],
        )

    def test_the_study_has_what_the_tests_bound(self):
        """The C++ tests read bounds.json, `figures` the study."""
        runs = figures.runs()
        for name, entry in figures.bounds()["runs"].items():
            words = ["draw", f"scenarios/{entry['scenario']}.yaml"]
            for setting in entry["set"]:
                words += ["--set", setting]
            for seed in entry["seeds"]:
                more = ["--set", f"seed={seed}"] if len(entry["seeds"]) > 1 else []
                self.assertEqual(runs[name].command(seed), words + more)
            self.assertEqual(runs[name].seeds, entry["seeds"], name)

    def test_sine_and_m_have_the_same_seeds(self):
        runs = figures.runs()
        self.assertEqual(runs["bowl-sine-realistic"].seeds, runs["bowl-m-realistic"].seeds)

    def test_the_worst_is_furthest_from_the_best(self):
        worst = figures.worst(
            [
                {"force_mean": 5.2, "ink_error_rms": 0.02, "coverage": 1.0},
                {"force_mean": 4.7, "ink_error_rms": 0.01, "coverage": 0.98},
            ]
        )
        self.assertEqual(worst, {"force_mean": 4.7, "ink_error_rms": 0.02, "coverage": 0.98})

    def test_every_table_can_be_made_of_nothing(self):
        for name in figures.TABLES:
            self.assertIn("–", figures.tables(lambda key: None)(name), name)

    def test_what_a_document_quotes_is_run(self):
        with tempfile.TemporaryDirectory() as folder:
            page = pathlib.Path(folder) / "page.md"
            page.write_text(
                inline("1", "koi.coverage")
                + inline("2", "bowl-sine-realistic@3.force_sd")
                + "\n<!-- figures:table readme -->\n<!-- /figures -->\n"
            )
            self.assertEqual(figures.needed_runs([page]), {"koi", "bowl-sine", "bowl-m", "bowl-sine-realistic", "bowl-m-realistic",
                 "bowl-sine-blind", "bowl-m-blind"})


class Documents(unittest.TestCase):
    """What stands in the tree; the program itself is asked by `./impedraw figures --check`."""

    def test_they_quote_what_figures_json_holds(self):
        self.assertEqual(
            figures.fill_all(
                figures.documents("all") + figures.shown("all"), figures.read_figures(), write=False
            ),
            [],
        )

    def test_a_picture_says_what_was_measured_and_a_stale_one_is_found(self):
        known = figures.read_figures()
        for page in figures.shown("all"):
            self.assertIn("ink_error_rms", figures.text_of(page), page.name)
        page = ROOT / "docs/images/drawn.png"
        self.assertEqual(figures.needed_runs([page]), {"bowl-sine", "bowl-m", "koi"})
        known["koi.ink_error_rms"] = dict(known["koi.ink_error_rms"], value=0.015)
        (told,) = figures.fill_all([page], known, write=False)
        self.assertIn("koi.ink_error_rms is quoted as '0.022', the program gives 0.015", told)

    def test_a_picture_that_says_nothing_is_stale(self):
        from PIL import Image

        with tempfile.TemporaryDirectory(dir=ROOT / "build") as folder:
            page = pathlib.Path(folder) / "silent.png"
            Image.new("RGB", (2, 2)).save(page)
            (told,) = figures.fill_all([page], figures.read_figures(), write=False)
            self.assertIn("does not say what was measured", told)

    def test_a_page_is_compared_but_for_the_day_and_one_in_a_last_digit(self):
        old = ["run on 2026-11-24, commit f3b3775: 305 runs", "| a | 0.022 / 1.000 |"]
        new = ["run on 2026-12-01, commit 0123abc+: 305 runs", "| a | 0.023 / 1.000 |"]
        self.assertEqual(study_pages.stale("p.md", old, new), [])
        for other in ("| a | 0.024 / 1.000 |", "| b | 0.022 / 1.000 |"):
            (told,) = study_pages.stale("p.md", old, [new[0], other])
            self.assertIn("p.md:2", told)
        (told,) = study_pages.stale("p.md", old, ["a line more", *new])
        self.assertIn("p.md:1: has\n    \n  measured is\n    a line more", told)
        self.assertEqual(len(study_pages.stale("p.md", old, new[:1])), 1)

    def test_cells_of_which_little_is_promised_are_listed(self):
        row = {"case": "a", "state": "ok", "not_drawn": '{"fold": 2}', "length_reachable": 100.0}
        rows = [
            {**row, "length_promised": 39.9},
            {**row, "case": "b", "length_promised": 40.1},
            {**row, "case": "c", "state": "nothing", "length_promised": None},
        ]
        self.assertEqual(study_pages.shy_list(rows), ["- `a`: 40 % (fold 2)", "- `c`: nothing (fold 2)"])

    def test_every_figure_says_where_it_is_from(self):
        entries = json.loads(figures.FIGURES.read_text())
        self.assertGreater(len(entries), 100)
        for entry in entries:
            self.assertLessEqual(
                {"id", "value", "unit", "command", "scenario", "commit"}, set(entry)
            )
            if "real_time_factor" in entry["id"]:
                self.assertFalse(entry["compared"], "a speed depends on its machine")
                self.assertIn("cores", entry["machine"])

    def test_a_wrong_quote_is_found(self):
        known = figures.read_figures()
        known = {key: dict(entry, value=entry["value"] * 1.5 + 1) for key, entry in known.items()}
        self.assertNotEqual(figures.fill_all(figures.documents("all"), known, write=False), [])


if __name__ == "__main__":
    unittest.main()
