// SPDX-License-Identifier: Apache-2.0
#include "afterglow/afterglow.h"

#include <cerrno>
#include <cstring>

const char *afterglow_strerror(int error) {
    switch (error) {
    case 0:
        return "no error";
    case -EACCES:
        return "you do not have the right to this stream; ask for the daemon's group of readers, "
               "or for that of images";
    case -EAGAIN:
        return "there is no new frame yet";
    case -EBADMSG:
        return "a frame in the ring contradicts itself";
    case -EBUSY:
        return "the daemon is still busy with earlier calls of this program";
    case -ECONNREFUSED:
        return "nobody answers at the address of the bus";
    case -ECONNRESET:
        return "the stream goes on with another daemon";
    case -EHOSTUNREACH:
        return "no afterglow daemon is on the bus";
    case -EINPROGRESS:
        return "the stream is not open yet";
    case -EINTR:
        return "a signal came while waiting for a frame";
    case -EINVAL:
        return "the library was called with an invalid argument";
    case -EMSGSIZE:
        return "a buffer is too small for its plane";
    case -ENOMEDIUM:
        return "this user has no session bus";
    case -ENOBUFS:
        return "the daemon has too many streams open to open another one";
    case -ENOENT:
        return "there is no such bus, or no such plane in the stream";
    case -EPERM:
        return "the shared memory lacks the seals that make it safe to read";
    case -EPIPE:
        return "the daemon has closed the stream";
    case -EPROTO:
        return "what the daemon sent is not a stream with an afterglow ring";
    case -EPROTONOSUPPORT:
        return "the daemon's ring is of another version than this library reads";
    case -ESTALE:
        return "the frame has been overwritten by newer ones, or is older than the stream";
    case -ETIMEDOUT:
        return "nothing came in the time allowed";
    default: {
        const char *sentence = ::strerrordesc_np(-error);
        return sentence != nullptr ? sentence : "unknown error";
    }
    }
}
