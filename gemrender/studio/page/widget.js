// The studio in a notebook: the page in a frame that can reach nothing of the notebook, and its messages handed on to
// the kernel and back. The page itself comes from the kernel, once a view, so that notebooks are not saved with it.

/** A frame of its own origin: it may run its scripts, save files and ask for a number, no more. */
const ALLOWED = 'allow-scripts allow-downloads allow-modals';
const WITHOUT = 'The studio needs its kernel: run the cell.';
/** What is told where the kernel has closed the widget, or is gone itself. */
const ENDS = ['comm:close', 'comm_live_update'];
/** So long the kernel may take to send the page [ms], before it is said that there is none. */
const PATIENCE = 15_000;

/** Whether the notebook is dark: JupyterLab's and VS Code's own word, else the system's. */
function isDark() {
    const { jpThemeLight } = document.body.dataset;
    if (jpThemeLight !== undefined) return jpThemeLight === 'false';
    if (/\bvscode-/.test(document.body.className)) return document.body.classList.contains('vscode-dark');
    return matchMedia('(prefers-color-scheme: dark)').matches;
}

/** The bytes of a message, as a buffer of its own. */
const bufferOf = ({ buffer, byteOffset, byteLength }) => buffer.slice(byteOffset, byteOffset + byteLength);

function render({ model, el }) {
    const view = Math.random().toString(36).slice(2);
    const note = document.createElement('p');
    const frame = document.createElement('iframe');
    frame.setAttribute('sandbox', ALLOWED);
    frame.title = 'gemrender studio';
    frame.style.cssText = `display: block; width: 100%; height: ${model.get('height')}px; border: 0; border-radius: 6px`;
    frame.hidden = true;
    el.replaceChildren(note, frame);
    const waiting = setTimeout(() => { note.textContent = WITHOUT; }, PATIENCE);
    const { port1: port, port2: other } = new MessageChannel();
    const tellTheme = () => port.postMessage({ isDark: isDark() });

    const hear = (content, buffers) => {
        if (content.view !== view) return;
        const buffer = bufferOf(buffers[0]);
        if (content.type === 'message') {
            port.postMessage(buffer, [buffer]);
            return;
        }
        clearTimeout(waiting);
        note.remove();
        frame.hidden = false;
        frame.addEventListener('load', () => {
            frame.contentWindow.postMessage('port', '*', [other]);
            tellTheme();
            port.postMessage({ isOpen: true });
        }, { once: true });
        frame.srcdoc = new TextDecoder().decode(buffer);
    };
    port.onmessage = ({ data }) => {
        if (typeof data === 'string') model.send({ view, type: 'message', text: data });
        else model.send({ view, type: 'message' }, undefined, [bufferOf(data)]);
    };
    const resize = () => { frame.style.height = `${model.get('height')}px`; };
    const end = () => port.postMessage({ isOpen: false });
    const themes = new MutationObserver(tellTheme);
    themes.observe(document.body, { attributes: true, attributeFilter: ['data-jp-theme-light', 'class'] });
    model.on('msg:custom', hear);
    model.on('change:height', resize);
    for (const name of ENDS) model.on(name, end);
    model.send({ view, type: 'begin' });
    return () => {
        clearTimeout(waiting);
        themes.disconnect();
        model.off('msg:custom', hear);
        model.off('change:height', resize);
        for (const name of ENDS) model.off(name, end);
        model.send({ view, type: 'end' });
        port.close();
    };
}

export default { render };
