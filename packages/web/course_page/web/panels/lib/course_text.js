// The pages of the course, read from course/NN_name/README.md: there is no other copy of the course.

const TERMINAL = /\s+# terminal (\d+)\s*$/;

// Return the blocks of a page below its heading: {kind, ...}: text {text}, heading {text}, list {items}, commands {commands:
// [{terminal, text}]}, output or code {text}, image {text, address}.
export function parseStep(markdown) {
  return parseBlocks(markdown.split('\n').slice(1));
}

function parseBlocks(lines) {
  const blocks = [];
  let terminal = '';
  for (let i = 0; i < lines.length; i += 1) {
    const line = lines[i];
    const fence = /^```(\w*)/.exec(line);
    if (fence) {
      const inner = [];
      for (i += 1; i < lines.length && !lines[i].startsWith('```'); i += 1) inner.push(lines[i]);
      if (fence[1] === 'bash') {
        const commands = inner.filter((text) => text.trim()).map((text) => {
          const found = TERMINAL.exec(text);
          if (found) [, terminal] = found;
          return {terminal, text: text.replace(TERMINAL, '').trim()};
        });
        blocks.push({kind: 'commands', commands});
      } else {
        blocks.push({kind: fence[1] === 'text' ? 'output' : 'code', text: inner.join('\n')});
      }
    } else if (line.startsWith('## ')) {
      blocks.push({kind: 'heading', text: line.slice(3)});
    } else if (/^!\[/.test(line)) {
      const image = /^!\[([^\]]*)\]\(([^)]+)\)/.exec(line);
      if (image) blocks.push({kind: 'image', text: image[1], address: image[2]});
    } else if (/^(\* |\d+\. )/.test(line)) {
      let block = blocks[blocks.length - 1];
      if (!block || block.kind !== 'list' || lines[i - 1] === '') blocks.push(block = {kind: 'list', items: []});
      block.items.push(line.replace(/^(\* |\d+\. )/, ''));
    } else if (/^ +\S/.test(line) && blocks.length && blocks[blocks.length - 1].kind === 'list') {
      const {items} = blocks[blocks.length - 1];
      items[items.length - 1] += ` ${line.trim()}`;
    } else if (line.trim() && !line.startsWith('<!--')) {
      const block = blocks[blocks.length - 1];
      if (block && block.kind === 'text' && lines[i - 1] && lines[i - 1].trim()) block.text += ` ${line.trim()}`;
      else blocks.push({kind: 'text', text: line.trim()});
    }
  }
  return blocks;
}

// Return the parts of a line: {kind, text, address}, with kind text, code, strong, em, key or link.
export function inline(text) {
  const pattern = /`([^`]+)`|\*\*([^*]+)\*\*|\*([^*]+)\*|<kbd>([^<]+)<\/kbd>|\[([^\]]+)\]\(([^)\s]+)\)/g;
  const parts = [];
  let end = 0;
  for (const found of text.matchAll(pattern)) {
    if (found.index > end) parts.push({kind: 'text', text: text.slice(end, found.index)});
    const [, code, strong, em, key, link, address] = found;
    const kind = code !== undefined ? 'code' : strong !== undefined ? 'strong' : em !== undefined ? 'em'
      : key !== undefined ? 'key' : 'link';
    parts.push({kind, text: code ?? strong ?? em ?? key ?? link, address});
    end = found.index + found[0].length;
  }
  if (end < text.length) parts.push({kind: 'text', text: text.slice(end)});
  return parts;
}
