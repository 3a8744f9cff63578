/* drop WINDOW PATH: drags PATH over an X11 window and drops it there, as a file manager does (XDND version
 * 5). Exit codes: 0 the window took it, 1 it refused, 2 wrong usage, 5 no display, 6 no answer within a
 * minute.
 *
 * The source's part of the protocol: own XdndSelection; tell the window XdndEnter (what there is) and
 * XdndPosition (where); on its XdndStatus, tell it XdndDrop; when it asks for the selection, hand over
 * "file://PATH" as text/uri-list; wait for its XdndFinished. */
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATIENCE_MS = 60000, VERSION = 5 };

typedef struct drag {
    Display *display;
    Window source, target;
    Atom selection, enter, position, status, drop, finished, copy, uri_list;
    char uri[3 * 4096 + 16];
} drag;

static void tell(const drag *d, Atom message, long a, long b, long c, long e)
{
    XEvent event = {.xclient = {.type = ClientMessage,
                                .window = d->target,
                                .message_type = message,
                                .format = 32,
                                .data.l = {(long)d->source, a, b, c, e}}};
    XSendEvent(d->display, d->target, False, NoEventMask, &event);
    XFlush(d->display);
}

static void hand_over(const drag *d, const XSelectionRequestEvent *request)
{
    bool known = request->target == d->uri_list;
    XEvent event = {.xselection = {.type = SelectionNotify,
                                   .requestor = request->requestor,
                                   .selection = request->selection,
                                   .target = request->target,
                                   .property = known ? request->property : None,
                                   .time = request->time}};
    if (known)
        XChangeProperty(d->display, request->requestor, request->property, d->uri_list, 8, PropModeReplace,
                        (const unsigned char *)d->uri, (int)strlen(d->uri));
    XSendEvent(d->display, request->requestor, False, NoEventMask, &event);
    XFlush(d->display);
}

/* Answers requests for the selection until the window sends `message`. */
static bool wait_for(const drag *d, Atom message, XClientMessageEvent *answer)
{
    struct pollfd readable = {.fd = ConnectionNumber(d->display), .events = POLLIN};
    while (XPending(d->display) || poll(&readable, 1, PATIENCE_MS) > 0) {
        XEvent event;
        XNextEvent(d->display, &event);
        if (event.type == SelectionRequest) hand_over(d, &event.xselectionrequest);
        if (event.type != ClientMessage || event.xclient.message_type != message) continue;
        *answer = event.xclient;
        return true;
    }
    fprintf(stderr, "drop: no answer\n");
    return false;
}

static void write_uri(const char *path, char *uri)
{
    uri += sprintf(uri, "file://");
    for (; *path; path++) uri += sprintf(uri, strchr(" %", *path) ? "%%%02X" : "%c", *path);
    strcpy(uri, "\r\n");
}

int main(int argc, char **argv)
{
    drag d = {0};
    XClientMessageEvent answer;
    if (argc != 3 || strlen(argv[2]) > 4096) return 2;
    d.target = strtoul(argv[1], NULL, 0);
    write_uri(argv[2], d.uri);
    d.display = XOpenDisplay(NULL);
    if (!d.display) return 5;
    Atom *const atoms[] = {&d.selection, &d.enter,    &d.position, &d.status,
                           &d.drop,      &d.finished, &d.copy,     &d.uri_list};
    static const char *const names[] = {"XdndSelection", "XdndEnter",    "XdndPosition",   "XdndStatus",
                                        "XdndDrop",      "XdndFinished", "XdndActionCopy", "text/uri-list"};
    for (int i = 0; i < 8; i++) *atoms[i] = XInternAtom(d.display, names[i], False);
    d.source = XCreateSimpleWindow(d.display, DefaultRootWindow(d.display), 0, 0, 1, 1, 0, 0, 0);
    XSetSelectionOwner(d.display, d.selection, d.source, CurrentTime);

    tell(&d, d.enter, (long)VERSION << 24, (long)d.uri_list, None, None);
    tell(&d, d.position, 0, 320L << 16 | 240, CurrentTime, (long)d.copy);
    if (!wait_for(&d, d.status, &answer)) return 6;
    bool taken = answer.data.l[1] & 1;
    if (taken) {
        tell(&d, d.drop, 0, CurrentTime, 0, 0);
        if (!wait_for(&d, d.finished, &answer)) return 6;
        taken = answer.data.l[1]; /* bit 0 by the book; GLFW 3.3 answers with the number of bytes it read */
    }
    XCloseDisplay(d.display);
    return taken ? 0 : 1;
}
