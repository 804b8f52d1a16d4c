/* Goniotile's release number; the protocol and each file format carry their own version number. */
#ifndef GONIOTILE_VERSION_H
#define GONIOTILE_VERSION_H
#define GONIOTILE_VERSION       "0.1.0"
#define GONIOTILE_VERSION_MAJOR 0
#define GONIOTILE_VERSION_MINOR 1
#define GONIOTILE_VERSION_PATCH 0
#endif
