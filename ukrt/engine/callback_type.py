"""The C type of the engine's callback, which is PortAudio's, for whoever calls an address of it through ctypes."""

import ctypes

# int callback(const void *in, void *out, unsigned long frames, const void *time, unsigned long flags, void *userdata)
_POINTER, _ULONG = ctypes.c_void_p, ctypes.c_ulong
CALLBACK = ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _POINTER, _ULONG, _POINTER, _ULONG, _POINTER)
