"""One page that holds all of a report: charts as SVG, pictures and films as text, style and script inside."""
import base64
import html
import io
import json
import shlex
from pathlib import Path

from PIL import Image

from launching.programs import command
from results import provenance

from . import budget, tables, trace
from .plausibility import findings
from .style import inline

HERE = Path(__file__).parent
PICTURES = (("activation", "Activation"), ("fibres", "Fibres"), ("potential", "Potential"), ("ejection", "Blood in ejection"),
            ("filling", "Blood in filling"), ("deformation", "Deformation"))
FILMS = {"potential": "Potential", "calcium": "Calcium", "displacement": "Displacement", "fibres": "Fibres", "velocity": "Velocity of the blood",
         "pressure": "Pressure of the blood"}


def text(words):
    return html.escape(str(words))


def table(heading, rows, words=False):
    """`words`: all columns are text, and begin at the left; keys in the first break at their dots."""
    broken = lambda cell, k: text(cell).replace(".", ".<wbr>") if words and k == 0 else text(cell)
    cells = lambda row, tag: "".join(f"<{tag}>{broken(cell, k)}</{tag}>" for k, cell in enumerate(row))
    body = "".join(f"<tr>{cells(row, 'td')}</tr>" for row in rows)
    return (f'<div class="scroll"><table{" class=words" if words else ""}><thead><tr>{cells(heading, "th")}</tr></thead>'
            f"<tbody>{body}</tbody></table></div>")


def section(title, *parts):
    parts = [part for part in parts if part]
    return f"<section><h2>{text(title)}</h2>{''.join(parts)}</section>" if parts else ""


def warnings(run, heading):
    """What is implausible, then what the programs have warned of."""
    found = [f"<li>{text(finding.what)}. <code>{text(finding.key)}</code>: {text(finding.hint)}</li>" for finding in findings(run)]
    told = "".join(f"<li>{text(program)}: {text(line)}</li>" for program, line in run.warnings())
    return ((f"<h3>{text(run.name)}</h3>" if heading else "")
            + (f'<ul class="findings">{"".join(found)}</ul>' if found else "<p>Nothing implausible was found.</p>")
            + (f"<details><summary>Warnings in the logs</summary><ul>{told}</ul></details>" if told else ""))


def grid(cards, wide=()):
    """`wide`: the cards that take a row of their own."""
    return '<div class="grid">' + "".join(f'<div class="card{" wide" * (card in wide)}">{card}</div>' for card in cards) \
        + "</div>" if cards else ""


def pictures(run):
    """Stills; those that the films show, too, only where there are no films."""
    cards, wide, has_films = [], [], (run.folder / "report/films.json").exists()
    for name, title in PICTURES:
        file = run.folder / "report" / f"{name}.png"
        if file.exists() and not (has_films and name in ("potential", "deformation")):
            image, data = Image.open(file), io.BytesIO()
            image.convert("RGB").save(data, "WEBP", quality=85)  # a tenth of the PNG's size
            cards.append(f'<img alt="{text(title)}: {text(run.name)}" '
                         f'src="data:image/webp;base64,{base64.b64encode(data.getvalue()).decode()}">')
            if image.width > 1.3 * image.height:
                wide.append(cards[-1])
    return grid(cards, wide)


def films(run, number):
    """A slider and one image for each film; without a script one frame stands."""
    file = run.folder / "report/films.json"
    if not file.exists():
        return ""
    played = json.loads(file.read_text())
    figures, frames, first = [], {}, len(played["captions"]) // 5
    for name, pictures_of in played["frames"].items():
        scale, own = played["scales"][name], f"film{number}-{name}"
        frames[own] = pictures_of
        figures.append(f'<figure><img id="{own}" alt="{text(FILMS.get(name, name))}" src="{pictures_of[first]}">'
                       f'<figcaption>{text(scale["label"])}</figcaption><div class="scale">{text(scale["low"])}'
                       f'<i style="background:linear-gradient(90deg,{",".join(scale["colours"])})"></i>{text(scale["high"])}'
                       "</div></figure>")
    data = json.dumps({"captions": played["captions"], "frames": frames}).replace("</", "<\\/")
    return (f'<div class="card"><div class="films">{"".join(figures)}</div><div class="player" data-frames="frames{number}">'
            f'<button type="button">play</button><input type="range" min="0" max="{len(played["captions"]) - 1}" value="{first}" '
            f'aria-label="instant"><output></output></div></div><script type="application/json" id="frames{number}">{data}'
            "</script>")


def errors(run):
    """The error budget of the scene, if there is one."""
    if not (file := budget.find(run)):
        return ""
    differ = budget.differences(run, file)
    if differ is None:
        of = "Of a scene with the name of this one; its run is not there any more, so that they cannot be compared."
    elif differ:
        of = "Of the same scene but for " + ", ".join(f"{key}: {tables.as_written(value)}" for key, value in differ.items()) + "."
    else:
        of = "Of this scene."
    return (f"<p>{text(of)} Each discretisation made finer or coarser alone; 'error' estimates what the scene's own is wrong by, "
            f"cost is over the scene's ({text(file)}).</p>" + table(*budget.table(file)))


def idle(run):
    """When nobody works, of a run with a trace."""
    file = run.folder / "trace.json"
    if not file.exists():
        return ""
    try:
        return table(*trace.rows_of_gaps(trace.slices(file)))
    except (ValueError, KeyError) as error:
        return f"<p>trace.json: {text(error)}</p>"


def repetition(run):
    """The command that has made the run, and the one that repeats it from its resolved scene."""
    words = provenance(run.folder).get("command") or []
    if words and Path(words[0]).name == "coupler":  # which the launcher starts
        words = [*shlex.split(command()), "run", *words[1:]]
    made = f"<p>Made by</p><pre>{text(shlex.join(words))}</pre>" if words else ""
    scene = run.folder / "scene.resolved.yaml"
    return made + f"<p>Repeated by</p><pre>{text(shlex.join([command(), 'run', str(scene), '--out', 'NEW_FOLDER']))}</pre>"


def differences(runs, defaults):
    if not defaults and len(runs) == 1:
        return "<p>What differs from the defaults is not known here: the coupler, who prints them, is not built.</p>"
    what = "Keys that differ between the runs" if len(runs) > 1 else "Keys that differ from their default"
    return f"<p>{what}</p>" + table(*tables.scene_differences(runs, defaults), words=True)


def whole_scene(run):
    file = run.folder / "scene.resolved.yaml"
    return (f"<details><summary>Whole scene of {text(run.name)}, with the meaning of all keys</summary>"
            f"<pre>{text(file.read_text())}</pre></details>" if file.exists() else "")


def about(run):
    scheme, mesh = run.scheme, run.scene.get("geometry.mesh", "")
    shape = run.scene.get("geometry.shape", "")
    where = {"ideal_left_ventricle": f"ideal left ventricle, mesh {mesh}", "file": f"mesh {Path(str(mesh)).name}"}
    parts = [where.get(shape, shape), scheme,
             f"{run.history.time[-1] * 1e3:.0f} ms in {len(run.history.time) - 1} steps"]
    return ", ".join(part for part in parts if part)


def page(runs, drawn, defaults, missing_pictures=""):
    """The report as text. `drawn`: {title: SVG}; `defaults`: of all keys of a scene; `missing_pictures`: why there are none."""
    several = len(runs) > 1
    title = "Comparison of " + ", ".join(run.name for run in runs) if several else runs[0].name
    parts = [section("Implausible", *(warnings(run, several) for run in runs)),
             section("Indicators", table(*tables.indicators(runs))), section("Curves", grid([f"<h3>{text(name)}</h3>{inline(svg, name)}" for name, svg in drawn.items()]))]
    looks = [(f"<h3>{text(run.name)}</h3>" if several else "") + films(run, k) + pictures(run) for k, run in enumerate(runs)
             if films(run, k) or pictures(run)]
    parts.append(section("Pictures", *looks, f"<p>{text(missing_pictures)}</p>" if missing_pictures else ""))
    parts.append(section("Error budget", *((f"<h3>{text(run.name)}</h3>" if several else "") + errors(run) for run in runs
                                           if errors(run))))
    parts.append(section("Cost", *((f"<h3>{text(run.name)}</h3>" if several else "") + table(*tables.cost(run)) + idle(run)
                                   for run in runs if tables.cost(run)[1])))
    parts.append(section("Scene", differences(runs, defaults), *map(whole_scene, runs)))
    parts.append(section("Origin", *((f"<h3>{text(run.name)}</h3>" if several else "") + repetition(run) for run in runs),
                         table(*tables.origin(runs), words=True)))
    lines = "".join(f'<p class="about">{text(run.name + ": " if several else "")}{text(about(run))}</p>' for run in runs)
    return ('<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
            f'content="width=device-width, initial-scale=1"><title>{text(title)}</title>'
            f"<style>{(HERE / 'page.css').read_text()}</style></head><body><h1>{text(title)}</h1>{lines}{''.join(parts)}"
            f"<script>{(HERE / 'page.js').read_text()}</script></body></html>\n")
