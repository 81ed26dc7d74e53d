// Files: opened by dropping them on the page or by the button, and saved.

import { byId, data, element } from './shared.js';

const KINDS = {
    toml: 'Stone file (.toml)', asc: 'GemCad design (.asc)', gem: 'GemCad design (.gem)', gcs: 'Gem Cut Studio (.gcs)',
    stl: 'Mesh (.stl)', glb: 'Mesh (.glb)', scores: 'Scores (.csv)', report: 'Report (.html)', map: 'Map (.png)', link: 'Copy link',
};
/** Largest file that is sent: as large as the server takes [bytes]. */
const MOST_BYTES = 32 * 1024 * 1024;

export function download(name, parts, type) {
    const address = URL.createObjectURL(new Blob(parts, { type }));
    element('a', { href: address, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(address), 2000);
}

/** Take dropped and chosen files: `take(name, bytes)`, or `refuse(words)`. */
export function listenForFiles(take, refuse) {
    const open = async (file) => {
        if (!file) return;
        if (file.size > MOST_BYTES) {
            refuse(`${file.name}: is larger than ${MOST_BYTES} bytes`);
            return;
        }
        take(file.name, new Uint8Array(await file.arrayBuffer()));
    };
    const isFile = (event) => [...(event.dataTransfer?.types ?? [])].includes('Files');
    window.addEventListener('dragover', (event) => {
        if (!isFile(event)) return;
        event.preventDefault();
        document.body.classList.add('dropping');
    });
    window.addEventListener('dragleave', (event) => {
        if (!event.relatedTarget) document.body.classList.remove('dropping');
    });
    window.addEventListener('drop', (event) => {
        if (!isFile(event)) return;
        event.preventDefault();
        document.body.classList.remove('dropping');
        open(event.dataTransfer.files[0]);
    });
    const input = byId('file');
    byId('open').addEventListener('click', () => input.click());
    input.addEventListener('change', () => {
        open(input.files[0]);
        input.value = '';
    });
}

export function fillSaveMenu(save) {
    const list = byId('save').querySelector('.list');
    for (const [kind, words] of Object.entries(KINDS)) {
        if (kind === 'link' && data.isEmbedded) continue; // a notebook's own address is no link to it
        const button = element('button', { type: 'button' }, words);
        button.dataset.kind = kind;
        button.addEventListener('click', () => {
            byId('save').open = false;
            byId('save').querySelector('summary').focus();
            save(kind);
        });
        list.append(button);
    }
}

/** Menus close where one clicks elsewhere, and by Escape. */
export function listenToMenus() {
    const menus = [...document.querySelectorAll('details.menu')];
    document.addEventListener('click', (event) => {
        for (const menu of menus) if (!menu.contains(event.target)) menu.open = false;
    });
    document.addEventListener('keydown', (event) => {
        if (event.key !== 'Escape') return;
        for (const menu of menus) {
            if (!menu.open) continue;
            menu.open = false;
            menu.querySelector('summary').focus();
        }
    });
}
