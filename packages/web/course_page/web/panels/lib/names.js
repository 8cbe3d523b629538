// Short names of nodes and topics.

// Return a short name without the number that rospy gives anonymous nodes; of a long name the end is kept, which tells
// more than its start.
export function shortName(full, most = 34) {
  const name = full.replace(/_\d+_\d{10,}$/, '');
  return name.length > most ? `…${name.slice(1 - most)}` : name;
}
