// What keys, buttons, the time line and dropped files do.
import {StreamError} from "./bytes.js";
import {Headset} from "./xr.js";

export const of = id => document.getElementById(id);
export const layouts = ["one", "side by side", "anaglyph"];

/// Of a key, with or without shift.
const nameOf = event => event.key.length === 1 ? event.key.toLowerCase() : event.key;
/// What a button or the time line does itself with a key.
const isControlsOwn = (control, key) => control.tagName === "BUTTON" ? key === " " || key === "Enter"
    : control.id === "time" && /^(Arrow|Page|Home|End)/.test(key);

/// What can be done, by its key.
const actionsOf = page => ({
    " ": () => page.player?.toggle(),
    "c": () => {
        page.head.centre();
        page.headset.recentre();
    },
    "Home": () => page.player.seek(0),
    ",": () => page.player.step(-1),
    ".": () => page.player.step(1),
    "l": () => page.player.loops = !page.player.loops,
    "v": () => page.layout = (page.layout + 1) % layouts.length,
    "t": () => of("figures").hidden = !of("figures").hidden,
    "h": () => of("help").hidden = !of("help").hidden,
    "o": () => of("file").click(),
    "g": () => page.head.followDevice().then(
        may => may || page.refuse(new StreamError("no motion sensors: this device has none, or the browser was not allowed to read them"))),
    "f": () => (document.fullscreenElement ? document.exitFullscreen()
                                           : document.documentElement.requestFullscreen?.())?.catch(() => {}),
});

function listenForKeys(page) {
    const actions = actionsOf(page);
    addEventListener("keydown", event => {
        const name = nameOf(event);
        if (event.ctrlKey || event.metaKey || event.altKey || isControlsOwn(event.target, event.key))
            return;
        if (page.head.key(name, true))
            return event.preventDefault();
        const needsPlayer = [" ", "Home", ",", ".", "l"].includes(name);
        if (name in actions && (page.player || !needsPlayer)) {
            event.preventDefault();
            if (!event.repeat || [",", "."].includes(name))
                actions[name]();
        }
    });
    addEventListener("keyup", event => page.head.key(nameOf(event), false));
    for (const button of document.querySelectorAll("[data-key]"))
        button.addEventListener("click", () => {
            button.blur();
            actions[button.dataset.key]();
        });
    document.querySelector("[data-key=f]").hidden = !document.fullscreenEnabled;  // phones have none
    of("gyroscope").hidden = !("ontouchstart" in window);
}

function listenForTimeLine(page) {
    of("time").addEventListener("input", () => page.player?.seek(Number(of("time").value)));
    of("time").addEventListener("pointerdown", () => page.isSought = true);
    for (const end of ["pointerup", "pointercancel"])
        addEventListener(end, () => {
            if (page.isSought)
                of("time").blur();  // arrows turn again
            page.isSought = false;
        });
}

function listenForFiles(page) {
    of("file").addEventListener("change", () => {
        const [file] = of("file").files;
        of("file").value = "";  // the same one may be opened again
        if (file)
            page.openFile(file);
    });
    addEventListener("dragover", event => event.preventDefault());
    addEventListener("drop", event => {
        event.preventDefault();
        if (event.dataTransfer.files[0])
            page.openFile(event.dataTransfer.files[0]);
    });
}

export function listenFor(page) {
    listenForKeys(page);
    listenForTimeLine(page);
    listenForFiles(page);
    page.canvas.addEventListener("webglcontextlost", () => page.fail(new StreamError(
        "the browser has lost the GPU: reload the page")));
    Headset.isThere().then(isThere => of("headset").hidden = !isThere);
    of("headset").addEventListener("click", () => page.player
        ? page.headset.start().catch(error => page.refuse(error))
        : page.refuse(new StreamError("open a stream first")));
}
