"""A compiled quantity: called on one point or on any batch, compiled at its first use, shipped by description."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from mafsil import threads
from mafsil.kernels import batch, cache, call, identity, runtime, ufunc
from mafsil.kernels.cache import KernelRecord, Store
from mafsil.kernels.call import BIND, CALL
from mafsil.kernels.compiler import Order, obtain
from mafsil.kernels.image import FROM_PYTHON, Image
from mafsil.kernels.layout import BATCH, LANES, SINGLE, Signature
from mafsil.kernels.lazy import lazy
from mafsil.kernels.streaming import STREAMED
from mafsil.kernels.target import Target
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.kernels.device.batch as device_batch
    import mafsil.kernels.ptx.program as program
    import mafsil.kernels.traced_array as traced_array
else:
    device_batch = lazily("mafsil.kernels.device.batch")
    program = lazily("mafsil.kernels.ptx.program")
    traced_array = lazily("mafsil.kernels.traced_array")


@dataclass(frozen=True)
class Addresses:
    """Entry points for compiled loops; valid while the kernel lives, each compiled when it is first asked for."""

    image: Image

    @property
    def batch(self) -> int:
        """Any rows, in the lanes of vectors: void (char **args, npy_intp *dims, npy_intp *steps, void *data)."""
        return self.image.part(BATCH).addresses[BATCH]

    @property
    def few(self) -> int:
        """Contiguous rows, one after another, as fast as a single call each; called as `batch`."""
        return self.image.few

    @property
    def single(self) -> int:
        """One row: void (double *in0, ..., double *out0, ...)."""
        return self.image.part(SINGLE).addresses[SINGLE]

    @property
    def lanes(self) -> int:
        """Eight rows side by side, element by element (`layout.LANES`): void (double *in, double *out0, ...)."""
        return self.image.part(LANES).addresses[LANES]


@dataclass(frozen=True, eq=False, repr=False)
class Kernel:
    """Machine code of an expression, made when it is first needed: for single calls and for batches apart.

    Attributes:
        signature: name and ports.
        key: the caller's words for the expression; equal words must mean equal expressions.
        build: makes the function, one column per port; a module-level function or a partial of one, so that the
            kernel pickles.
        fingerprints: of the sources that shape the expression (`identity.fingerprint`).
        doc: docstring.
        fallback: called as `fallback(evaluate, *args, **named)` in place of `evaluate(*args, **named)` for all that is
            not one plain contiguous point.
        recipe: picklable (function, arguments) that makes this kernel again; None pickles the attributes.
        target: machine to compile for; None is this one.
        parameters: of the call as Python writes them, for `inspect.signature`; the ports, `out`, `threads` if empty.
        answer: a subclass of `tuple` without room of its own, which machine code fills with the several results of one
            point. Where their very last number is not a number, and for batches, a plain tuple comes out.
    """

    signature: Signature
    key: str
    build: Callable[[], Any]
    fingerprints: tuple[str, ...] = ()
    doc: str = ""
    fallback: Callable[..., Any] | None = None
    recipe: tuple[Callable[..., Kernel], tuple[Any, ...]] | None = None
    target: Target | None = None
    parameters: str = ""
    answer: type[tuple[Any, ...]] | None = None

    def __call__(self, *args: Any, **named: Any) -> Any:
        """Evaluate at one point or over a batch; see `Evaluator.__call__`."""
        return self.call(*args, **named)

    @lazy
    def call(self) -> Callable[..., Any]:
        """The fastest way to evaluate: a builtin that takes plain arrays itself and hands the rest to `evaluate`."""
        slow = self.evaluate if self.fallback is None else partial(self.fallback, self.evaluate)
        if not runtime.available():
            return slow
        at = self.image.part(CALL).addresses
        words = self.doc, slow, self, self.parameters, self.answer
        routine = call.builtin(at[CALL], at[BIND], self.signature, *words)
        self.evaluate.twins = routine.__self__  # pyright: ignore[reportFunctionMemberAccess]
        return routine

    @lazy
    def evaluate(self) -> batch.Evaluator:
        """The careful way: arguments checked and named, batches split over threads."""
        image = self.image
        ufuncs = (lambda: self.ufunc, lambda: self.point_ufunc, lambda: self.streamed)
        run = batch.Loops(*ufuncs, lambda: image.at_hand(BATCH))
        return batch.Evaluator(self.signature, run, image.row_ns, self.on_device, self.trace)

    def on_device(self, *args: Any, out: Any = None) -> Any:
        """Evaluate arrays that lie on an NVIDIA device there; see `DeviceEvaluator.__call__`."""
        return self._on_device(*args, out=out)

    def trace(self, *arrays: Any) -> Any:
        """What the kernel computes of arrays of expressions; see `traced_array`."""
        return traced_array.answer(self.function, self.signature, arrays)

    @lazy
    def function(self) -> Any:
        """The expression, kept for arrays of expressions."""
        return self.build()

    @lazy
    def _on_device(self) -> Callable[..., Any]:
        """The kernel for the device, compiled at its first use."""
        # Imported here: whoever has no device never pays for what prints PTX.
        return device_batch.DeviceEvaluator(self.signature, lambda: program.device_program(self.signature, self.build))

    @lazy
    def ufunc(self) -> Callable[..., Any]:
        """NumPy's generalised ufunc: broadcasting, strides, casting, `out=`; no checks for NaN. It does not pickle."""
        return ufunc.gufunc(self.image.loop, self.signature, self.doc, self.image)

    @lazy
    def point_ufunc(self) -> Callable[..., Any]:
        """The same for contiguous arguments of one point, by the single entry."""
        return ufunc.gufunc(self.image.few, self.signature, self.doc, self.image)

    @lazy
    def streamed(self) -> Callable[..., Any]:
        """The same ufunc, but its results are written in whole lines past the caches (`streaming`)."""
        return ufunc.gufunc(self.image.loop, self.signature, self.doc, self.image, STREAMED)

    @property
    def addresses(self) -> Addresses:
        """Entry points for compiled loops."""
        return Addresses(self.image)

    @property
    def provenance(self) -> KernelRecord:
        """Where the code comes from."""
        return self.image.provenance

    @lazy
    def image(self) -> Image:
        """The code, part by part; asking for it traces, asking it for a part compiles."""
        return obtain(self.order(cache.default()))

    def order(self, store: Store) -> Order:
        """What is compiled, and under which key."""
        key = identity.tape_key(self.key, self.signature, self.fingerprints)
        return Order(key, self.signature, self.build, self.target, store)

    def __reduce__(self) -> tuple[Callable[..., Kernel], tuple[Any, ...]]:
        if self.recipe is not None:
            return self.recipe
        same = (self.signature, self.key, self.build, self.fingerprints, self.doc, self.fallback, None, self.target)
        return Kernel, (*same, self.parameters, self.answer)

    def __copy__(self) -> Kernel:
        return self

    def __deepcopy__(self, _memo: dict[int, Any]) -> Kernel:
        return self

    def __repr__(self) -> str:
        return f"<Kernel {self.signature.name}: {self.signature.gufunc}>"

    def __str__(self) -> str:
        return str(self.provenance)


def compile(
    signature: Signature,
    build: Callable[[], Any],
    *,
    key: str,
    fingerprints: Iterable[str] = (),
    doc: str = "",
    fallback: Callable[..., Any] | None = None,
    recipe: tuple[Callable[..., Kernel], tuple[Any, ...]] | None = None,
    target: Target | None = None,
    parameters: str = "",
    answer: type[tuple[Any, ...]] | None = None,
) -> Kernel:
    """A kernel that compiles at its first use; arguments as the attributes of `Kernel`."""
    return Kernel(signature, key, build, tuple(fingerprints), doc, fallback, recipe, target, parameters, answer)


def warm(kernels: Sequence[Kernel], workers: int | None = None) -> None:
    """Compile or load several kernels at once, for single calls and for batches, those in the cache at little cost.

    LLVM works on one kernel at a time in a process but without Python's lock, so that the next kernel is traced and
    lowered meanwhile.

    Args:
        kernels: to be ready afterwards.
        workers: threads that share the work; the default is all cores of the process.

    Raises:
        KernelError: the first failure, after all others are done.
    """
    count = threads.available() if workers is None else threads.check_count(workers, "workers")

    def ready(index: int) -> None:
        kernel = kernels[index]
        for part in FROM_PYTHON:
            kernel.image.part(part)
        _ = kernel.call

    threads.run(ready, len(kernels), count)
