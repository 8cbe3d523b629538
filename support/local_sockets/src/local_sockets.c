/* Keeps ROS on this machine where ROS_HOSTNAME says so: what listens on all addresses listens on loopback instead.

   The C++ part of ROS binds the XML-RPC server of every node (rosout, robot_state_publisher) to 0.0.0.0, whatever
   ROS_HOSTNAME is; rospy does not. ./run preloads this library (LD_PRELOAD, see tools/environment.bash).

   It acts only while ROS_HOSTNAME, or without it ROS_IP, names a loopback address, so two machines work as ever.
   TURTLE_ROBOTONT_LOCAL=all: for the sockets of every program; else for those of libroscpp and libxmlrpcpp alone, so
   that in a shell no other program notices. It is no wall: a program may call the kernel itself. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <netinet/in.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

static const char *const ros_libraries[] = {"/libxmlrpcpp.so", "/libroscpp.so"};

static int only_this_machine(void) {
  const char *name = getenv("ROS_HOSTNAME");
  if (name == NULL || *name == '\0') name = getenv("ROS_IP");
  return name != NULL && (strcmp(name, "localhost") == 0 || strncmp(name, "127.", 4) == 0 || strcmp(name, "::1") == 0);
}

static int concerns(void *caller) {
  const char *whose = getenv("TURTLE_ROBOTONT_LOCAL");
  Dl_info library;
  if (!only_this_machine()) return 0;
  if (whose != NULL && strcmp(whose, "all") == 0) return 1;
  if (dladdr(caller, &library) == 0 || library.dli_fname == NULL) return 0;
  for (size_t i = 0; i < sizeof ros_libraries / sizeof *ros_libraries; ++i)
    if (strstr(library.dli_fname, ros_libraries[i]) != NULL) return 1;
  return 0;
}

/* Bind for real, to loopback where the address is the wildcard. A socket for both IPv6 and IPv4 gets IPv4's loopback:
   that is what the name localhost always leads to. */
static int bind_locally(int fd, const struct sockaddr *address, socklen_t length) {
  int (*real)(int, const struct sockaddr *, socklen_t);
  *(void **)&real = dlsym(RTLD_NEXT, "bind");
  if (address != NULL && address->sa_family == AF_INET && length >= sizeof(struct sockaddr_in)) {
    struct sockaddr_in local;
    memcpy(&local, address, sizeof local);
    if (local.sin_addr.s_addr == htonl(INADDR_ANY)) {
      local.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      return real(fd, (struct sockaddr *)&local, sizeof local);
    }
  } else if (address != NULL && address->sa_family == AF_INET6 && length >= sizeof(struct sockaddr_in6)) {
    struct sockaddr_in6 local;
    memcpy(&local, address, sizeof local);
    if (IN6_IS_ADDR_UNSPECIFIED(&local.sin6_addr)) {
      int only_six = 1;
      socklen_t size = sizeof only_six;
      if (getsockopt(fd, IPPROTO_IPV6, IPV6_V6ONLY, &only_six, &size) == 0 && !only_six) {
        static const unsigned char mapped[16] = {[10] = 0xff, 0xff, 127, 0, 0, 1};
        memcpy(&local.sin6_addr, mapped, sizeof mapped);
      } else {
        local.sin6_addr = in6addr_loopback;
      }
      return real(fd, (struct sockaddr *)&local, sizeof local);
    }
  }
  return real(fd, address, length);
}

__attribute__((visibility("default"))) int bind(int fd, const struct sockaddr *address, socklen_t length) {
  int (*real)(int, const struct sockaddr *, socklen_t);
  if (concerns(__builtin_return_address(0))) return bind_locally(fd, address, length);
  *(void **)&real = dlsym(RTLD_NEXT, "bind");
  return real(fd, address, length);
}

/* A socket that listens without an address would get the wildcard. */
__attribute__((visibility("default"))) int listen(int fd, int backlog) {
  int (*real)(int, int);
  *(void **)&real = dlsym(RTLD_NEXT, "listen");
  if (concerns(__builtin_return_address(0))) {
    struct sockaddr_storage address;
    socklen_t length = sizeof address;
    if (getsockname(fd, (struct sockaddr *)&address, &length) == 0 &&
        ((address.ss_family == AF_INET && ((struct sockaddr_in *)&address)->sin_port == 0) ||
         (address.ss_family == AF_INET6 && ((struct sockaddr_in6 *)&address)->sin6_port == 0)))
      bind_locally(fd, (struct sockaddr *)&address, length);
  }
  return real(fd, backlog);
}
