"""What the map writes: the words of its newest picture, and where each of them stands."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations

from playwright.sync_api import Page

WATCHED = """(() => {
    const pictures = new Map();
    const counts = new Map();
    const { clearRect, fillText } = CanvasRenderingContext2D.prototype;
    const whole = ({ canvas }, box) => box[0] === 0 && box[1] === 0 && box[2] > canvas.clientWidth - 1 && box[3] > canvas.clientHeight - 1;
    CanvasRenderingContext2D.prototype.clearRect = function (...box) {
        if (whole(this, box)) {
            counts.set(this.canvas, (counts.get(this.canvas) ?? 0) + 1);
            pictures.set(this.canvas, []);
        }
        return clearRect.apply(this, box);
    };
    CanvasRenderingContext2D.prototype.fillText = function (text, x, y, ...most) {
        const told = this.measureText(text);
        const less = Math.min(1, (most[0] ?? Infinity) / told.width);
        const at = this.getTransform();
        const corners = [
            [x - less * told.actualBoundingBoxLeft, y - told.actualBoundingBoxAscent],
            [x + less * told.actualBoundingBoxRight, y + told.actualBoundingBoxDescent],
        ].map(([left, top]) => at.transformPoint(new DOMPoint(left, top)));
        const [xs, ys] = [corners.map((each) => each.x), corners.map((each) => each.y)];
        const ratio = this.canvas.width / this.canvas.clientWidth;
        const edges = [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)].map((each) => each / ratio);
        pictures.get(this.canvas)?.push([text, ...edges]);
        return fillText.call(this, text, x, y, ...most);
    };
    const told = (of, within) => [...of]
        .filter(([canvas]) => canvas.isConnected && canvas.closest(within))
        .flatMap(([, said]) => said);
    window.drawnPictures = (within) => told(counts, within).reduce((all, each) => all + each, 0);
    window.drawnWords = (within) => told(pictures, within);
})()"""
"""Notes what is written on a canvas since it was cleared as a whole, but for parts of a pixel; and how often one was."""


@dataclass(frozen=True, slots=True)
class Word:
    """Some words, and the edges of their letters in pixels of the page, from the upper left corner of the map."""

    text: str
    left: float
    top: float
    right: float
    bottom: float

    def covers(self, other: Word) -> bool:
        """Whether letters of both would stand in one place; edges that touch do not count."""
        wide = min(self.right, other.right) - max(self.left, other.left)
        high = min(self.bottom, other.bottom) - max(self.top, other.top)
        return wide > 1.0 and high > 1.0


def overlapping(words: Iterable[Word]) -> list[tuple[Word, Word]]:
    """Those that stand in one another."""
    return [(one, other) for one, other in combinations(words, 2) if one.covers(other)]


def watch_words(page: Page) -> None:
    """Note what is drawn from the next page on."""
    page.add_init_script(WATCHED)


def pictures_of(page: Page, within: str = "#plant-map") -> int:
    """How many there were: to be read before a deed, for `words_of` to tell what is drawn after it."""
    return int(page.evaluate("within => window.drawnPictures(within)", within))


def words_of(page: Page, within: str = "#plant-map", *, after: int | None = None) -> list[Word]:
    """What stands in the newest picture: of all its layers, read at one moment.

    Args:
        page: where `watch_words` was called.
        within: what the map stands in.
        after: as many pictures are too old; where it is given, a later one is waited for.
    """
    if after is not None:
        told = [within, after]
        page.wait_for_function("([within, after]) => window.drawnPictures(within) > after", arg=told)
    return [Word(*each) for each in page.evaluate("within => window.drawnWords(within)", within)]
