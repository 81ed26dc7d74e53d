// What the studio shares with the report, as a module: classic scripts there, as a page on disk needs them.
/* global GemDom, GemLight, GemPage, GemRay, GemStage, GemStone, GemTracer */

export const { number, find, signed, boundText, element, drawing, inNextFrame, tip, announce, define } = GemDom;
export const { data, cards, hear } = GemPage;
export const Light = GemLight;
export const Ray = GemRay;
export const Tracer = GemTracer;
export const { geometryOf } = GemStone;
export const { Stage } = GemStage;

export const byId = (id) => document.getElementById(id);
