"""Long work: progress, cancellation, Ctrl-C, other threads and forks."""

import os
import signal
import subprocess
import sys
import threading

import pytest

import pathmarch

BIG = (640, 360)


def test_progress_counts_up_to_all_samples(ball):
    seen = []
    pathmarch.render(ball, (16, 9), 5, progress=lambda done, total: seen.append((done, total)))
    assert seen[-1] == (5.0, 5.0) and all(total == 5.0 for _, total in seen)
    assert seen == sorted(seen)


def test_a_callback_that_returns_false_cancels(ball):
    with pytest.raises(pathmarch.Cancelled) as caught:
        pathmarch.render(ball, BIG, 100_000, backend="cpu", progress=lambda done, total: done < 2)
    error = caught.value
    assert 2 <= error.samples < 100_000 and error.picture.shape == (360, 640, 3)
    expected = pathmarch.render(ball, BIG, error.samples, backend="cpu")
    assert abs(error.picture - expected).mean() < 0.1 and str(error) == f"cancelled after {error.samples} samples"


def test_callbacks_may_return_anything_else(ball):
    for answer in (None, True, 1, "no", []):
        assert pathmarch.render(ball, (8, 8), 2, progress=lambda *_: answer).shape == (8, 8, 3)


def test_exceptions_of_a_callback_end_rendering(ball):
    def fail(done, total):
        raise KeyError("stop")

    with pytest.raises(KeyError, match="stop"):
        pathmarch.render(ball, BIG, 100_000, progress=fail)
    assert pathmarch.render(ball, (8, 8), 1).shape == (8, 8, 3), "the next picture is rendered"


def test_meshes_are_cancelled(ball):
    seen = []
    with pytest.raises(pathmarch.Cancelled):
        pathmarch.Scene(ball).mesh(1500, progress=lambda done, total: bool(seen.append((done, total))))
    assert 0 <= seen[0][0] <= seen[0][1] == 1


def test_other_threads_go_on_while_a_picture_is_rendered(ball):
    interval = sys.getswitchinterval()
    go, ended = threading.Event(), []
    thread = threading.Thread(target=lambda: (go.wait(), ended.append(True)))
    thread.start()
    sys.setswitchinterval(1000)  # Only a released lock lets the other thread run.
    try:
        scene = pathmarch.Scene(ball)
        go.set()
        scene.render(BIG, 4, backend="cpu")
        assert ended == [True]
    finally:
        sys.setswitchinterval(interval)
        thread.join()


def test_pictures_are_rendered_by_many_threads_at_once(ball):
    scene, expected = pathmarch.Scene(ball), pathmarch.render(ball, (64, 36), 3, backend="cpu").tobytes()
    pictures = []
    work = lambda: pictures.append(scene.render((64, 36), 3, backend="cpu").tobytes())  # noqa: E731
    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert pictures == [expected] * 8


SCRIPT = """
import signal, sys, pathmarch
# Interrupts are ignored in the background of a shell.
signal.signal(signal.SIGINT, signal.default_int_handler)
started = []
def progress(done, total):
    if not started:
        started.append(True)
        print("started", flush=True)
try:
    pathmarch.render(sys.argv[1], (640, 360), 1_000_000, backend="cpu", progress=progress)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent differently")
def test_ctrl_c_interrupts_a_picture(ball):
    process = subprocess.Popen([sys.executable, "-c", SCRIPT, ball], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout.readline() == "started\n"
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=120)
    finally:
        process.kill()
    assert (out, process.returncode) == ("interrupted\n", 0)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_forked_processes_are_refused_instead_of_waiting_forever(ball):
    script = """
import os, sys, pathmarch
scene = pathmarch.Scene(sys.argv[1])
scene.render((8, 8), 1)
child = os.fork()
if child == 0:
    try:
        scene.render((8, 8), 1)
    except RuntimeError as error:
        print("spawn" in str(error), flush=True)
    os._exit(0)
os.waitpid(child, 0)
"""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", script, ball], capture_output=True, text=True, timeout=120
    )
    assert done.stdout == "True\n", done.stderr
