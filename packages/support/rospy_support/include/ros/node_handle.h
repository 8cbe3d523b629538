// ROS Noetic's ros/node_handle.h includes boost/bind.hpp, and so programs write boost::bind(&C::f, this, _1).
// Debian's includes boost/bind/bind.hpp, which leaves _1 in boost::placeholders.
#pragma once
#pragma GCC system_header  // without it, -Wpedantic warns of include_next
#include_next <ros/node_handle.h>
#ifndef BOOST_BIND_NO_PLACEHOLDERS
using namespace boost::placeholders;
#endif
