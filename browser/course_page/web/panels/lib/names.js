// Names of nodes and topics in little room.

// Return a name that fits, without the number that rospy gives anonymous nodes: the end of a long one tells more than its
// beginning.
export function shortName(full, most = 34) {
  const name = full.replace(/_\d+_\d{10,}$/, '');
  return name.length > most ? `…${name.slice(1 - most)}` : name;
}
