#!/usr/bin/python3
"""drop_file.py WINDOW FILE: drops a file onto a window of X, as a file manager does (XDND, version 5)."""
import pathlib
import sys
import time

from Xlib import X, display, error
from Xlib.protocol import event

LIMIT = 60  # seconds


def main():
    window_id, path = int(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
    server = display.Display()
    atom = server.intern_atom
    target = server.create_resource_object("window", window_id)
    source = server.screen().root.create_window(0, 0, 1, 1, 0, X.CopyFromParent)
    source.set_selection_owner(atom("XdndSelection"), X.CurrentTime)
    uris = atom("text/uri-list")

    def send(kind, *data):
        target.send_event(event.ClientMessage(window=target, client_type=atom(kind),
                                              data=(32, [source.id, *data])))
        server.flush()

    def answer(request):
        request.requestor.change_property(request.property, request.target, 8,
                                          (path.as_uri() + "\r\n").encode())
        request.requestor.send_event(event.SelectionNotify(
            time=request.time, requestor=request.requestor, selection=request.selection,
            target=request.target, property=request.property))
        server.flush()

    send("XdndEnter", 5 << 24, uris, 0, 0)
    send("XdndPosition", 0, 0, X.CurrentTime, atom("XdndActionCopy"))
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        if not server.pending_events():
            time.sleep(0.01)
            continue
        what = server.next_event()
        if what.type == X.SelectionRequest:
            answer(what)
        elif what.type == X.ClientMessage and what.client_type == atom("XdndStatus"):
            send("XdndDrop", 0, X.CurrentTime, 0, 0)
        elif what.type == X.ClientMessage and what.client_type == atom("XdndFinished"):
            return 0
    print("the window took nothing", file=sys.stderr)
    return 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except error.XError as wrong:
        sys.exit(str(wrong))
